//! A dynamic approximation of numbers over exact realizations.

use leafwise_plugin_abi::{LwDynamics, LwMapFn};

use super::Subject;
use super::answers::Tester;
use super::compare::{derivative, largest, within};
use super::function::{Function, Points};
use super::problems::{lend as lend_system, problems};
use crate::foreign::{ForeignPart, HostObjects};
use crate::host::RealizationToLend;
use crate::smoke_failure::SmokeFailure;
use crate::trial_points::states;

/// A step at which functions are tried, and one that hardly moves.
const STEP: f64 = 1e-2;
const TINY: f64 = 1e-9;

/// Tries the part on each problem that it serves.
pub(super) fn try_part(subject: &mut Subject, table: &LwDynamics) -> Result<(), SmokeFailure> {
    for problem in problems(subject.maker.part.dimensions) {
        let d = problem.system.dimension();
        let lend = || {
            let values = problem.system.parameter_values();
            let lend = RealizationToLend::new(&problem.realization, values.len()).ok()?;
            Some(HostObjects {
                realization: Some(lend.lend(&values)),
                ..lend_system(&problem)?
            })
        };
        let mut run = |_: &ForeignPart, tester: &mut Tester| run(tester, table, d);
        subject.on_problem(&problem.name, d, &lend, &mut run)?;
    }
    Ok(())
}

/// Tries all functions; false where the states are outside the domain.
fn run(tester: &mut Tester, table: &LwDynamics, d: usize) -> Result<bool, SmokeFailure> {
    let section: Vec<Vec<f64>> = states(d)
        .into_iter()
        .map(|x| [x, vec![0.0; d]].concat())
        .collect();
    let zero = vec![vec![0.0; d]; section.len()];
    // The point, what is there without a step, the map and its Jacobian.
    type Case<'a> = (&'a str, LwMapFn, LwMapFn, Vec<Vec<f64>>, &'a [Vec<f64>]);
    let cases: [Case<'_>; 3] = [
        (
            "one_form",
            table.one_form,
            table.one_form_jacobian,
            states(d),
            &zero,
        ),
        (
            "embedding",
            table.embedding,
            table.embedding_jacobian,
            states(d),
            &section,
        ),
        (
            "flow",
            table.flow,
            table.flow_jacobian,
            section.clone(),
            &section,
        ),
    ];
    for (name, function, jacobian, points, at_rest) in cases {
        if function.is_none() {
            continue;
        }
        let results = at_rest[0].len();
        let points = Points::of(points);
        let tried = |h: f64| Function {
            name,
            function,
            results,
            epsilon: 1.0,
            h,
        };
        if tester.try_at(&tried(STEP), &points)?.is_none() {
            return Ok(false);
        }
        let still = tester.try_at(&tried(TINY), &points)?;
        for (found, expected) in still.iter().flatten().zip(at_rest) {
            let identity = format!("{name} at h = {TINY:e}, which leaves sigma(M) in place,");
            within(&identity, found, expected, 1e-4 * (1.0 + largest(expected)))?;
        }
        let columns = points.point[0].len();
        let name = format!("{name}_jacobian");
        let of_map = Function {
            name: &name,
            function: jacobian,
            results: results * columns,
            ..tried(STEP)
        };
        if jacobian.is_some()
            && let Some(jacobian) = tester.try_at(&of_map, &points)?
        {
            derivative(&name, &jacobian[0], &points.point[0], |y| {
                let found = tester.try_at(&tried(STEP), &Points::of(vec![y.to_vec()]))?;
                Ok(found.map(|mut all| all.swap_remove(0)))
            })?;
        }
    }
    Ok(true)
}
