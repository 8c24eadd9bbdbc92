//! Kicks at times: events that act on the state where a function of the time alone is zero.

use leafwise_walk::Clock;

use super::Refusal;
use super::events::Events;
use crate::document::{SceneDocument, StepSpec};

/// Places of a run that are looked at, and steps from each.
const PLACES: u64 = 32;
const STEPS: u64 = 8;

/// Parts of a step at which the function is evaluated.
const PARTS: u32 = 61;

/// The longest step over the time between two kicks: of longer ones the walk does not resolve the function.
const LONGEST: f64 = 2.0 / 3.0;

/// Refuses steps that are too long for the kicks of a scene, of which they would pass over some.
///
/// # Errors
/// At the step.
pub(super) fn check_kicks(
    document: &SceneDocument,
    events: &Events,
    clock: Option<Clock>,
    (initial, parameters): (&[f64], &[f64]),
) -> Result<(), Refusal> {
    let (Some(section), Some(_), Some(clock)) = (&events.section, &events.act, clock) else {
        return Ok(());
    };
    let mut variables = section.difference.variables().into_iter();
    if (variables.next(), variables.next()) != (Some(clock.time), None) {
        return Ok(());
    }
    let spec = &document.method.step;
    let step = spec.time_step();
    let mut state = initial.to_vec();
    let begins = initial[clock.time];
    let mut at = |time: f64| {
        state[clock.time] = begins + time;
        section.difference.evaluate(&state, parameters)
    };
    let steps = document.run.steps.value;
    let apart = (steps / PLACES).max(STEPS);
    let mut least = f64::INFINITY;
    for first in (0..PLACES).map(|place| place * apart) {
        if first >= steps {
            break;
        }
        let (mut sign, mut kicked) = (0.0, None);
        let parts = u32::try_from(STEPS).unwrap_or(1) * PARTS;
        for part in 0..=parts {
            // Unequal parts, which no period has in common with all of them.
            let shift = 0.5 * (f64::from(part) * 0.618_033_988_749_895).fract();
            let time = step * (first as f64 + (f64::from(part) + shift) / f64::from(PARTS));
            let value = at(time);
            if value == 0.0 || value.is_nan() {
                continue;
            }
            if sign * value < 0.0 {
                if let Some(before) = kicked {
                    least = least.min((time - before).abs());
                }
                kicked = Some(time);
            }
            sign = value.signum();
        }
    }
    // A crossing lies up to a part and a half of a step before the time at which it is seen.
    let between = least + 1.5 * step.abs() / f64::from(PARTS);
    if step.abs() <= LONGEST * between {
        return Ok(());
    }
    // Half of the time between two of them, with three digits and no more than that.
    let half = rounded_down(0.5 * (least - 1.5 * step.abs() / f64::from(PARTS)).max(0.25 * least));
    let (place, change) = match spec {
        StepSpec::TimeStep(given) => (given.place(), half.copysign(step)),
        StepSpec::Factors { epsilon, h } => {
            let change = half / epsilon.value.value.abs();
            (h.place(), change.copysign(h.value.value))
        }
    };
    Err(Box::new(document.diagnostic(
        &place,
        format!(
            "`{}` acts about every {least:.2e}, and steps of {step:?} pass over some of it: two thirds of that time is the longest step",
            section.text
        ),
        "too long",
        Some(format!("write {} = {change:?}", spec.key())),
    )))
}

/// A positive number with three digits, not above its value.
fn rounded_down(value: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(value)) - 2.0);
    let digits = libm::floor(value / unit);
    format!("{:.6e}", digits * unit).parse().unwrap_or(value)
}
