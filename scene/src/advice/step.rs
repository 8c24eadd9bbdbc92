//! A step that is too long: two of half its length lead elsewhere.

use leafwise_core::StepError;

use super::{Advice, AdviceKind, number};
use crate::compose::ComposedRun;

/// The part of a step's motion that halving it may change. A method of order m then errs by about (2ᵐ − 1)⁻¹ of it, and
/// its error falls as its order says, or nearly so; above, neither is known.
const COARSE: f64 = 0.1;

/// At the first of the run's states where one step and two of half its length differ by more, or the two fail.
pub(super) fn advice(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    let message = states.iter().find_map(|x| {
        let whole = increment(run, x, 1).ok()?;
        let halves = match increment(run, x, 2) {
            Ok(halves) => halves,
            Err(error) => {
                return Some(format!(
                    "from a state of the run a step is taken, and two of half its length are not: {error}"
                ));
            }
        };
        let part = difference(x, &whole, &halves);
        (part > COARSE).then(|| {
            format!(
                "a step is too long for its order: two of half its length change a coordinate's motion by {} of it",
                number(part)
            )
        })
    })?;
    let half = 0.5 * run.plan.epsilon * run.plan.h;
    let short: f64 = format!("{half:.12e}").parse().unwrap_or(half);
    Some(Advice {
        kind: AdviceKind::CoarseStep,
        message,
        change: format!("time-step = {short:?}"),
    })
}

/// What two increments differ by over what they are: the largest of each over the coordinates, relative to these.
pub(super) fn difference(x: &[f64], whole: &[f64], halves: &[f64]) -> f64 {
    let (mut apart, mut motion) = (0.0_f64, 0.0_f64);
    for ((x, whole), halves) in x.iter().zip(whole).zip(halves) {
        let size = x.abs().max((x + whole).abs()).max((x + halves).abs());
        if size > 0.0 {
            apart = apart.max((whole - halves).abs() / size);
            motion = motion.max(halves.abs() / size);
        }
    }
    // Round-off of a state is no motion.
    if apart > f64::EPSILON * 64.0 {
        apart / motion
    } else {
        0.0
    }
}

/// The motion from x over the run's step, in so many parts.
pub(super) fn increment(run: &ComposedRun, x: &[f64], parts: u32) -> Result<Vec<f64>, StepError> {
    let values = run.system.parameter_values();
    let (map, plan) = (run.method.map(), &run.plan);
    let mut stepper = map.stepper(1, &values, plan.epsilon, plan.h / f64::from(parts));
    let low = vec![0.0; x.len()];
    let (mut state, mut whole) = (x.to_vec(), vec![0.0; x.len()]);
    for _ in 0..parts {
        let mut increment = vec![0.0; x.len()];
        let mut outcome = [Ok(())];
        stepper.increment(&state, &low, &mut increment, &mut outcome);
        let [outcome] = outcome;
        outcome?;
        for ((x, whole), part) in state.iter_mut().zip(&mut whole).zip(&increment) {
            *x += part;
            *whole += part;
        }
        if state.iter().any(|x| !x.is_finite()) {
            return Err(StepError::NonFinite {
                what: "the new state",
            });
        }
    }
    Ok(whole)
}
