//! A step map of numbers on the problems it serves.

use leafwise_plugin_abi::LwStepMap;

use super::Subject;
use super::answers::Tester;
use super::compare::{derivative, largest, within};
use super::function::{Function, Points};
use super::problems::{lend, problems};
use crate::foreign::ForeignPart;
use crate::smoke_failure::SmokeFailure;
use crate::trial_points::states;

/// A step at which functions are tried, and one that hardly moves.
const STEP: f64 = 1e-2;
const TINY: f64 = 1e-9;

/// Tries the part on each problem that it serves.
pub(super) fn try_part(subject: &mut Subject, table: &LwStepMap) -> Result<(), SmokeFailure> {
    for problem in problems(subject.maker.part.dimensions) {
        let d = problem.system.dimension();
        let lend = || lend(&problem);
        let mut run = |_: &ForeignPart, tester: &mut Tester| run(tester, table, d);
        subject.on_problem(&problem.name, d, &lend, &mut run)?;
    }
    Ok(())
}

/// Tries both functions; false where the states are outside the domain.
fn run(tester: &mut Tester, table: &LwStepMap, d: usize) -> Result<bool, SmokeFailure> {
    let points = Points {
        point: states(d),
        v: vec![vec![0.0; d]; 3],
        w: Vec::new(),
    };
    let increment = |h: f64| Function {
        name: "increment",
        function: table.increment,
        results: d,
        epsilon: 1.0,
        h,
    };
    if tester.try_at(&increment(STEP), &points)?.is_none() {
        return Ok(false);
    }
    let still = tester.try_at(&increment(TINY), &points)?;
    for (found, x) in still.iter().flatten().zip(&points.point) {
        let identity = format!("increment at h = {TINY:e}, which is none,");
        within(&identity, found, &vec![0.0; d], 1e-4 * (1.0 + largest(x)))?;
    }
    let tangent = Function {
        name: "tangent",
        function: table.tangent,
        results: d * d,
        ..increment(STEP)
    };
    if table.tangent.is_some()
        && let Some(tangent) = tester.try_at(&tangent, &Points::of(states(d)))?
    {
        derivative("tangent", &tangent[0], &points.point[0], |x| {
            let one = Points {
                point: vec![x.to_vec()],
                v: vec![vec![0.0; d]],
                w: Vec::new(),
            };
            let found = tester.try_at(&increment(STEP), &one)?;
            Ok(found.map(|all| all[0].iter().zip(x).map(|(i, x)| x + i).collect()))
        })?;
    }
    Ok(true)
}
