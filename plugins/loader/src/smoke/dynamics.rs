//! A dynamic approximation of numbers over exact realizations.

use leafwise_plugin_abi::{LwDynamics, LwMapFn};

use super::compare::{derivative, largest, within};
use super::function::{Function, Points};
use super::problems::{problems, states};
use super::{SmokeFailure, Subject, Tried};
use crate::foreign::{Instance, Lent};
use crate::host::{HostSystem, RealizationToLend};

/// A step at which functions are tried, and one that hardly moves.
const STEP: f64 = 1e-2;
const TINY: f64 = 1e-9;

/// Tries the part on each problem that it serves.
pub(super) fn try_part(subject: &Subject, table: &LwDynamics) -> Result<Tried, SmokeFailure> {
    let mut tried = Vec::new();
    for problem in problems(subject.part.dimensions) {
        let values = problem.system.parameter_values();
        let lend = RealizationToLend::new(&problem.realization, &values);
        let system = HostSystem::new(&problem.system, &values);
        let (Ok(lend), Ok(system)) = (lend, system) else {
            continue;
        };
        let lent = Lent {
            system: Some(system),
            realization: Some(lend.lend(&values)),
        };
        let d = problem.system.dimension();
        let Some(mut instance) = subject.instance(d, lent)? else {
            continue;
        };
        if run(&mut instance, table, d)? {
            tried.push(problem.name);
        }
    }
    Ok(tried)
}

/// Tries all functions; false where the states are outside the domain.
fn run(instance: &mut Instance, table: &LwDynamics, d: usize) -> Result<bool, SmokeFailure> {
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
        if tried(STEP).try_at(instance, &points)?.is_none() {
            return Ok(false);
        }
        let still = tried(TINY).try_at(instance, &points)?;
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
            && let Some(jacobian) = of_map.try_at(instance, &points)?
        {
            derivative(&name, &jacobian[0], &points.point[0], |y| {
                let found = tried(STEP).try_at(instance, &Points::of(vec![y.to_vec()]))?;
                Ok(found.map(|mut all| all.swap_remove(0)))
            })?;
        }
    }
    Ok(true)
}
