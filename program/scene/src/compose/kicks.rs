//! Kicks at times: events that act on the state where a function of the time alone is zero.

use leafwise_walk::Clock;

use super::Refusal;
use super::events::Events;
use crate::document::{SceneDocument, StepSpec};

/// Places of a run that are looked at, and steps from each.
const PLACES: u32 = 32;
const STEPS: u32 = 8;

/// Parts of a step at which the function is evaluated.
const PARTS: u32 = 61;

/// The longest step over the time between two kicks: of longer ones the walk does not resolve the function.
const LONGEST: f64 = 2.0 / 3.0;

/// How far the time between two kicks is rounded, relative to it.
const ROUNDED: f64 = 1e-9;

/// How often a step is shortened, at most, until it shows every kick.
const MOST_HALVES: u32 = 60;

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
    let end = document.run.steps.value as f64 * step;
    let least = least_apart(&mut at, step, end);
    let is_resolved = |step: f64, least: f64| step.abs() <= LONGEST * (1.0 + ROUNDED) * least;
    if is_resolved(step, least) {
        return Ok(());
    }
    // A long step shows no more than that there are many: shorter ones tell how many.
    let mut half = 0.5 * least;
    for _ in 0..MOST_HALVES {
        let own = least_apart(&mut at, half.copysign(step), end);
        if is_resolved(half, own) {
            break;
        }
        half = 0.5 * own.min(half);
    }
    let (least, half) = (2.0 * half, rounded_down(half));
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

/// The least time between two changes of sign of a function, at places of a run of steps of this length.
fn least_apart(at: &mut dyn FnMut(f64) -> f64, step: f64, end: f64) -> f64 {
    let steps = libm::ceil(end / step);
    let apart = libm::floor(steps / f64::from(PLACES)).max(f64::from(STEPS));
    let mut least = f64::INFINITY;
    for first in (0..PLACES).map(|place| f64::from(place) * apart) {
        if first >= steps {
            break;
        }
        let (mut before, mut changed) = (None::<(f64, f64)>, None::<f64>);
        for part in 0..=STEPS * PARTS {
            // Unequal parts, which no period has in common with all of them.
            let shift = 0.5 * (f64::from(part) * 0.618_033_988_749_895).fract();
            let time = step * (first + (f64::from(part) + shift) / f64::from(PARTS));
            let value = at(time);
            if value == 0.0 || value.is_nan() {
                continue;
            }
            if let Some((known, _)) = before.filter(|(_, sign)| sign * value < 0.0) {
                let change = changes_at(at, [known, time], value);
                if let Some(last) = changed.replace(change) {
                    least = least.min((change - last).abs());
                }
            }
            before = Some((time, value.signum()));
        }
    }
    least
}

/// The time between two at which a function takes the sign that it has at the second.
fn changes_at(at: &mut dyn FnMut(f64) -> f64, [mut from, mut to]: [f64; 2], value: f64) -> f64 {
    for _ in 0..60 {
        let middle = f64::midpoint(from, to);
        *(if at(middle) * value > 0.0 {
            &mut to
        } else {
            &mut from
        }) = middle;
    }
    to
}

/// A positive number with three digits, not above its value.
fn rounded_down(value: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(value)) - 2.0);
    let digits = libm::floor(value / unit);
    format!("{:.6e}", digits * unit).parse().unwrap_or(value)
}
