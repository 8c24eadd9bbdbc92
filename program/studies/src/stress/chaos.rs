//! Chaotic orbits, where the state cannot be a test.

use leafwise_core::solver::judge::larger;
use leafwise_core::{StepMap, Walk};

use super::case::{Case, Outcome, StressError, StressOptions};
use super::setup::{UNIT_ROUNDOFF, distance, largest, method};
use crate::verify::Problem;

pub(super) const CASES: [Case; 2] = [
    Case {
        family: "chaos",
        name: "steps-are-reversible",
        asked: "a chaotic orbit of the heavy top, 2*10^4 steps of 0.1, n = 6, m = 4, and from every \
                tenth state one step there and back",
        expected: "Phi_-h(Phi_h(x)) = x within 32 u |x| everywhere on the orbit; gravity and \
                   vertical, invariant quadratic forms of e(3), within 1e-13: every truncation \
                   conserves them",
        run: reversible_steps,
    },
    Case {
        family: "chaos",
        name: "orbits-return",
        asked: "the same orbit, 1200 steps of 0.1 there and back, beside an orbit from 1e-10 away",
        expected: "the two part by a factor of 10^4 and more; the way back multiplies round-off as \
                   the way there multiplies 1e-10: the start is missed by at most 1e3 u/1e-10 of \
                   their largest distance",
        run: orbits_return,
    },
];

/// A top that swings and turns over: neighbouring orbits part like exp(0.13 t).
const TUMBLING: [f64; 6] = [1.0, 0.2, 0.1, 0.6, 0.0, 0.8];

fn casimirs(x: &[f64]) -> [f64; 2] {
    let (m, gamma) = x.split_at(3);
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    [product(gamma, gamma), product(m, gamma)]
}

fn reversible_steps(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("heavy-top")?;
    let parameters = problem.system.parameter_values();
    let method = method(&problem.system, 6, 4)?;
    let mut walk = Walk::new(&method, &parameters, 1.0, 0.1, &TUMBLING);
    let start = casimirs(&TUMBLING);
    let (mut worst, mut drift) = (0.0_f64, 0.0_f64);
    for _ in 0..2_000 {
        let x = walk.state().to_vec();
        let there = one_step(&method, &parameters, 0.1, &x)?;
        let back = one_step(&method, &parameters, -0.1, &there)?;
        let defect = distance(&back, &x) / largest(&x);
        worst = larger(worst, defect);
        walk.watch(10, |walk| {
            let change = distance(&casimirs(walk.state()), &start);
            drift = larger(drift, change);
        })?;
    }
    Ok(Outcome {
        is_met: worst <= 32.0 * UNIT_ROUNDOFF && drift <= 1e-13,
        measured: format!("back within {worst:.1e} of |x|; Casimirs within {drift:.1e}"),
    })
}

fn one_step(
    map: &dyn StepMap,
    parameters: &[f64],
    t: f64,
    x: &[f64],
) -> Result<Vec<f64>, StressError> {
    let mut walk = Walk::new(map, parameters, 1.0, t, x);
    walk.step()?;
    Ok(walk.state().to_vec())
}

fn orbits_return(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("heavy-top")?;
    let parameters = problem.system.parameter_values();
    let method = method(&problem.system, 6, 4)?;
    let (steps, apart) = (1200, 1e-10);
    let mut near = TUMBLING;
    near[0] += apart;
    let starts = [TUMBLING.to_vec(), near.to_vec()];
    let mut walk = Walk::of_each(&method, &problem.system, &starts, 0.1);
    let mut separation = apart;
    walk.watch(steps, |walk| {
        separation = distance(&walk.last(0).1, &walk.last(1).1).max(separation);
    })?;
    let (_, end) = walk.last(0);
    let mut back = Walk::new(&method, &parameters, 1.0, -0.1, &end);
    back.advance(steps)?;
    let missed = distance(back.state(), &TUMBLING);
    let bound = 1e3 * UNIT_ROUNDOFF / apart * separation;
    Ok(Outcome {
        is_met: missed <= bound && separation > 1e4 * apart,
        measured: format!(
            "missed by {missed:.1e}; 1e-10 grew to {separation:.1e}, which allows {bound:.1e}"
        ),
    })
}
