//! Orders far above what a step can feel.

use leafwise_core::{PartParameters, Registry, StepMap, Walk};

use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{UNIT_ROUNDOFF, distance, largest, method, pair};
use crate::verify::Problem;

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "orders",
        name: "n-30",
        asked: "the truncated realization of order 30 against the closed form in the same chart, \
                20 steps of 0.1 of the rigid body, m = 12",
        expected: "(|eps p|/2 pi)^32 is below round-off: the two orbits agree within 1e3 u |x|",
        run: realization,
    },
    Case {
        family: "orders",
        name: "m-12",
        asked: "Hamilton-Jacobi of order 12 over n = 12, 20 steps: the rigid body at t = 0.05, the \
                heavy top at t = 0.02",
        expected: "the flow by Gauss of order 16 within 1e-11 |x|",
        run: dynamics,
    },
];

/// Round-off of twenty steps.
const ROUND_OFF: f64 = 1e3 * UNIT_ROUNDOFF;

fn realization(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("rigid-body")?;
    let parameters = problem.system.parameter_values();
    let truncated = method(&problem.system, 30, 12)?;
    let exact = Registry::with_builtin().exact_realization(&problem.system, false);
    let Some(exact) = exact else {
        return Ok(Outcome {
            is_met: false,
            measured: "no realization of the rigid body is exact".to_owned(),
        });
    };
    let exact = pair(
        &problem.system,
        (exact.info.name, PartParameters::new()),
        (
            "hamilton-jacobi",
            PartParameters::new().with("order", 12_i64),
        ),
    )?;
    let orbit = |map: &dyn StepMap| -> Result<Vec<Vec<f64>>, StressError> {
        let mut walk = Walk::new(map, &parameters, 1.0, 0.1, &problem.initial);
        let mut states = Vec::new();
        walk.watch(20, |walk| states.push(walk.state().to_vec()))?;
        Ok(states)
    };
    let (one, other) = (orbit(&truncated)?, orbit(&exact)?);
    let mut worst = 0.0_f64;
    for (one, other) in one.iter().zip(&other) {
        worst = worst.max(distance(one, other) / largest(other));
    }
    Ok(Outcome {
        is_met: worst <= ROUND_OFF,
        measured: format!("at most {worst:.1e} of |x| apart"),
    })
}

fn dynamics(_: &StressOptions) -> Result<Outcome, StressError> {
    let registry = Registry::with_builtin();
    let mut tally = Tally::default();
    let mut worst = 0.0_f64;
    for (id, n, t) in [("rigid-body", 12, 0.05), ("heavy-top", 12, 0.02)] {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, n, 12)?;
        let mut walk = Walk::new(&method, &parameters, 1.0, t, &problem.initial);
        walk.advance(20)?;
        let flow = problem.flow(&registry, 20.0 * t)?;
        let error = distance(walk.state(), &flow) / largest(&flow);
        worst = worst.max(error);
        tally.take(error <= 1e-11, || format!("{id}: {error:.1e} off"));
    }
    Ok(tally.outcome(|count| format!("{count} systems, at most {worst:.1e} of |x| off")))
}
