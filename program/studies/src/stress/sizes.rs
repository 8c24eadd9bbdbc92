//! States of size 1e-300 to 1e300.

use leafwise_core::{StepError, Walk};

use super::attempt::increment;
use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::{UNIT_ROUNDOFF, distance, method};
use crate::verify::Problem;

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "sizes",
        name: "scaling",
        asked: "the rigid body at 2^k x with a step of 2^-k t, k from -300 to 200",
        expected: "2^k times the increment at x, within 150 u: only exponents differ",
        run: scaling,
    },
    Case {
        family: "sizes",
        name: "overflow",
        asked: "the rigid body at 1e150 x and 1e200 x, n = 4, m = 4, t = 0.1: S_3 is a quartic",
        expected: "x^4 has no double: NonFinite or LeftChart, not a number, and the state is intact",
        run: overflow,
    },
    Case {
        family: "sizes",
        name: "ends-of-the-doubles",
        asked: "five systems at x times 5e-324, 1e-300, 1e-150, 1e150 and 1e300, five steps of 0.1",
        expected: "every step gives finite numbers, or an error and an intact state",
        run: ends,
    },
];

fn scaling(_: &StressOptions) -> Result<Outcome, StressError> {
    let system = Problem::of_library("rigid-body")?.system;
    let parameters = system.parameter_values();
    let method = method(&system, 4, 2)?;
    let x = [1.0, 3.0, 3.0];
    let own = increment(&method, &parameters, (1.0, 0.125), &x)?;
    let mut tally = Tally::default();
    let mut worst = 0.0_f64;
    for exponent in [-300.0, -100.0, -3.0, 3.0, 100.0, 200.0] {
        let lambda = libm::exp2(exponent);
        let scaled = x.map(|x| x * lambda);
        let found = increment(&method, &parameters, (1.0, 0.125 / lambda), &scaled)?;
        let found: Vec<f64> = found.iter().map(|i| i / lambda).collect();
        let error = distance(&found, &own);
        worst = worst.max(error);
        tally.take(error <= 150.0 * UNIT_ROUNDOFF, || {
            format!("2^{exponent}: off by {error:.1e}")
        });
    }
    Ok(tally.outcome(|count| format!("{count} sizes, at most {worst:.1e} off")))
}

fn overflow(_: &StressOptions) -> Result<Outcome, StressError> {
    let problem = Problem::of_library("rigid-body")?;
    let parameters = problem.system.parameter_values();
    let method = method(&problem.system, 4, 4)?;
    let mut tally = Tally::default();
    let mut last = String::new();
    for size in [1e150, 1e200] {
        let x: Vec<f64> = problem.initial.iter().map(|x| x * size).collect();
        let mut walk = Walk::new(&method, &parameters, 1.0, 0.1, &x);
        let outcome = walk.step();
        let is_typed = matches!(
            outcome,
            Err(StepError::NonFinite { .. }
                | StepError::LeftChart { .. }
                | StepError::OtherBranch { .. })
        );
        tally.take(is_typed && walk.state() == x, || {
            format!("at {size:e}: {outcome:?} and {:?}", walk.state())
        });
        if let Err(error) = outcome {
            last = error.to_string();
        }
    }
    let first = last.split([':', ';']).next().unwrap_or_default().to_owned();
    Ok(tally.outcome(|count| format!("{count} refused: {first}")))
}

fn ends(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let (mut taken, mut refused) = (0, 0);
    for id in [
        "rigid-body",
        "lotka-volterra",
        "lotka-volterra-periodic",
        "heavy-top",
        "gradient",
    ] {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4)?;
        for size in [5e-324, 1e-300, 1e-150, 1e150, 1e300] {
            let x: Vec<f64> = problem.initial.iter().map(|x| x * size).collect();
            let mut walk = Walk::new(&method, &parameters, 0.1, 1.0, &x);
            let mut before = x;
            let outcome = walk.watch(5, |walk| {
                taken += 1;
                before.copy_from_slice(walk.state());
                tally.take(before.iter().all(|x| x.is_finite()), || {
                    format!("{id} at {size:e}: {before:?}")
                });
            });
            if let Err(error) = outcome {
                refused += 1;
                tally.take(walk.state() == before, || {
                    format!("{id} at {size:e}: {error}")
                });
            }
        }
    }
    Ok(tally.outcome(|_| format!("{taken} steps of finite numbers, {refused} refused")))
}
