//! States, parameters and steps that are not numbers.

use leafwise_core::StepError;

use super::attempt::{Attempt, attempt};
use super::case::{Case, Outcome, StressError, StressOptions, Tally};
use super::setup::method;
use crate::verify::Problem;

pub(super) const CASES: [Case; 3] = [
    Case {
        family: "not-numbers",
        name: "state",
        asked: "four systems with NaN or an infinity in each coordinate; ln(0) in a Hamiltonian",
        expected: "NonFinite, and no increment",
        run: state,
    },
    Case {
        family: "not-numbers",
        name: "parameters",
        asked: "three systems with NaN or an infinity in each parameter",
        expected: "a typed error and no increment; an infinite moment of inertia, 1/I = 0, may \
                   also give a finite step",
        run: parameters,
    },
    Case {
        family: "not-numbers",
        name: "step-size",
        asked: "four systems with epsilon or h NaN or infinite",
        expected: "a typed error, and no increment",
        run: step_size,
    },
];

const SYSTEMS: [&str; 4] = ["rigid-body", "lotka-volterra", "heavy-top", "gradient"];

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn state(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    for id in SYSTEMS {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 2)?;
        for bad in BAD {
            for at in 0..problem.initial.len() {
                let mut x = problem.initial.clone();
                x[at] = bad;
                let outcome = attempt(&method, &parameters, (0.1, 1.0), &x);
                let is_met = matches!(outcome, Attempt::Refused(StepError::NonFinite { .. }));
                tally.take(is_met, || format!("{id}, {x:?}: {outcome:?}"));
            }
        }
    }
    let problem = Problem::of_library("lotka-volterra-periodic")?;
    let method = method(&problem.system, 4, 4)?;
    let parameters = problem.system.parameter_values();
    let outcome = attempt(&method, &parameters, (0.1, 1.0), &[1.0, -1.9, 0.0]);
    let is_met = matches!(outcome, Attempt::Refused(StepError::NonFinite { .. }));
    tally.take(is_met, || format!("ln(0): {outcome:?}"));
    Ok(tally.outcome(|count| format!("{count} states refused")))
}

fn parameters(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    let mut finite = 0;
    for id in ["rigid-body", "heavy-top", "lotka-volterra-periodic"] {
        let problem = Problem::of_library(id)?;
        let given = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4)?;
        for bad in BAD {
            for at in 0..given.len() {
                let mut values = given.clone();
                values[at] = bad;
                let outcome = attempt(&method, &values, (0.1, 1.0), &problem.initial);
                let is_limit = bad.is_infinite() && matches!(outcome, Attempt::Solved { .. });
                finite += u32::from(is_limit);
                let is_met = is_limit || matches!(outcome, Attempt::Refused(_));
                tally.take(is_met, || format!("{id}, {values:?}: {outcome:?}"));
            }
        }
    }
    Ok(tally.outcome(|count| {
        format!("{count} sets of parameters: {finite} limits stepped, the others refused")
    }))
}

fn step_size(_: &StressOptions) -> Result<Outcome, StressError> {
    let mut tally = Tally::default();
    for id in SYSTEMS {
        let problem = Problem::of_library(id)?;
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4)?;
        for bad in BAD {
            for step in [(bad, 1.0), (0.1, bad), (bad, bad)] {
                let outcome = attempt(&method, &parameters, step, &problem.initial);
                let is_met = matches!(outcome, Attempt::Refused(_));
                tally.take(is_met, || format!("{id}, {step:?}: {outcome:?}"));
            }
        }
    }
    Ok(tally.outcome(|count| format!("{count} step sizes refused")))
}
