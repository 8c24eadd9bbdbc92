//! A single step and what may come of it.

use leafwise_core::{StepError, StepMap};

/// The outcome of one cold step.
#[derive(Debug)]
pub(super) enum Attempt {
    /// A finite increment, with the solution of the step's equation where there is one.
    Solved {
        /// Φ(x) − x.
        increment: Vec<f64>,
        /// y.
        solution: Option<Vec<f64>>,
    },
    /// An error that explains itself, and no increment.
    Refused(StepError),
    /// Forbidden outcome, in words: an increment that is not finite, or a nonzero one beside an error.
    Garbage(String),
}

/// One cold step from `x`.
pub(super) fn attempt(
    map: &dyn StepMap,
    parameters: &[f64],
    (epsilon, h): (f64, f64),
    x: &[f64],
) -> Attempt {
    let mut increment = vec![f64::NAN; x.len()];
    let mut outcome = [Ok(())];
    let mut stepper = map.stepper(1, parameters, epsilon, h);
    stepper.increment(x, &vec![0.0; x.len()], &mut increment, &mut outcome);
    let [outcome] = outcome;
    match outcome {
        Ok(()) if increment.iter().all(|i| i.is_finite()) => Attempt::Solved {
            increment,
            solution: stepper.solution(0),
        },
        Ok(()) => Attempt::Garbage(format!("a step of {increment:?} from {x:?}")),
        Err(error) if increment.iter().all(|i| *i == 0.0) => Attempt::Refused(error),
        Err(error) => Attempt::Garbage(format!("an increment of {increment:?} beside `{error}`")),
    }
}

/// The increment of one cold step, without anything else.
pub(super) fn increment(
    map: &dyn StepMap,
    parameters: &[f64],
    step: (f64, f64),
    x: &[f64],
) -> Result<Vec<f64>, StepError> {
    match attempt(map, parameters, step, x) {
        Attempt::Solved { increment, .. } => Ok(increment),
        Attempt::Refused(error) => Err(error),
        Attempt::Garbage(_) => Err(StepError::OF_INCREMENT),
    }
}
