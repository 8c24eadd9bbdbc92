//! Does a part of a library fit the system it is composed with?
//!
//! Built-in parts are made from the system's formulas. A library's part may be made for one tensor or one
//! Hamiltonian, which formulas alone do not say and functions need not check: it is seen at the initial
//! state.

use std::sync::Arc;

use leafwise_core::diagnostics::RealizationInstrument;
use leafwise_core::{Accuracy, BuildError, Evaluator, PoissonSystem, RealizationData, StepMap};

/// How far brackets on the section may be from a tensor, relative to it, and belong to it all the same:
/// what is smaller is an error, not another tensor.
const SAME: f64 = 1e-3;

/// Brackets are matrices d × 2d: beyond this d the first order alone is looked at.
const MOST: usize = 256;

/// Checks {α̂, α̂} = ε Π on the section, at a state and at another one near it. Messages call the realization `part`.
///
/// # Errors
/// [`BuildError::DoesNotFit`] where the brackets and ε Π are not alike at all. A state where this cannot be measured is
/// no error.
pub fn check_tensor(
    part: &'static str,
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    near: &[f64],
) -> Result<(), BuildError> {
    if near.len() > MOST {
        return Ok(());
    }
    let values = system.parameter_values();
    let Ok(mut instrument) = RealizationInstrument::new(system, realization, &values) else {
        return Ok(());
    };
    let size = largest(near);
    let beside: Vec<f64> = (0..near.len())
        .map(|i| near[i] + size / 32.0 * (1.0 - 0.375 * (i % 5) as f64))
        .collect();
    let zero = vec![0.0; near.len()];
    for x in [near, &beside] {
        let Ok(error) = instrument.measure(1.0, x, &zero) else {
            continue;
        };
        if error.relative.source > SAME + error.relative_floor {
            return Err(BuildError::DoesNotFit {
                part,
                reason: format!(
                    "it realizes another tensor: near the initial state its brackets {{alpha, alpha}} \
                     on the section differ from eps Pi by {:.1e} of their terms; take a realization of this \
                     system's tensor, or a system of the part's",
                    error.relative.source
                ),
            });
        }
    }
    Ok(())
}

/// How far brackets off the section may be from those of an exact realization, relative to their terms.
const EXACT: f64 = 1e-12;

/// Momenta at which formulas that claim to be exact are looked at, in units of the state: coordinate by coordinate they
/// differ.
const MOMENTA: [f64; 2] = [0.25, -0.0625];

/// Checks {α̂, α̂} = ε Π off the section too, near a state, where the realization claims to be exact. Messages call it
/// `part`.
///
/// # Errors
/// [`BuildError::DoesNotFit`] where the brackets and ε Π differ by more than round-off. A state where this cannot be
/// measured is no error.
pub(super) fn check_exactness(
    part: &'static str,
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    near: &[f64],
) -> Result<(), BuildError> {
    if near.len() > MOST || realization.accuracy() != Accuracy::Exact {
        return Ok(());
    }
    let values = system.parameter_values();
    let Ok(mut instrument) = RealizationInstrument::new(system, realization, &values) else {
        return Ok(());
    };
    for size in MOMENTA {
        let p: Vec<f64> = (0..near.len())
            .map(|i| size / (1.0 + 0.375 * (i % 5) as f64))
            .collect();
        let Ok(error) = instrument.measure(1.0, near, &p) else {
            continue;
        };
        let of_terms = error.relative;
        let largest = of_terms.source.max(of_terms.target).max(of_terms.dual_pair);
        if largest > EXACT + error.relative_floor {
            return Err(BuildError::DoesNotFit {
                part,
                reason: format!(
                    "it claims to be exact, and at p = {p:.2?} its brackets differ from eps Pi, -eps Pi and 0 by {largest:.1e} of \
                     their terms; correct the formulas, or claim an order n of the truncation: order = 2"
                ),
            });
        }
    }
    Ok(())
}

/// Step sizes, each so many times smaller than the one before.
const SIZES: i32 = 7;
const FINER: f64 = 16.0;

/// The move of the largest step, relative to the state.
const LARGEST_MOVE: f64 = 1.0 / 128.0;

/// Round-off of an increment in units of u and of the state.
const ROUND_OFF: f64 = 256.0;

/// Checks (Φ_h(x) − x)/t → −Π ∇H as t = εh → 0, coordinate by coordinate: the map begins as the flow does. Messages
/// call the part that the map is made of `part`.
///
/// With D(t) the quotient, 2 D(t/2) − D(t) converges faster, also where the flow rests. A coordinate belongs to another
/// motion where these numbers have a limit, and the limit is another one.
///
/// # Errors
/// [`BuildError::DoesNotFit`] where a coordinate belongs to another motion. Where this cannot be told, there is no
/// error.
pub fn check_first_order(
    part: &'static str,
    system: &PoissonSystem,
    map: &dyn StepMap,
    epsilon: f64,
    near: &[f64],
) -> Result<(), BuildError> {
    let values = system.parameter_values();
    let Some(field) = field(system, &values, near) else {
        return Ok(());
    };
    let (size, speed) = (largest(near), largest(&field));
    let ratio = LARGEST_MOVE * size / speed;
    let largest_step = if ratio > 0.0 && ratio.is_finite() {
        ratio
    } else {
        LARGEST_MOVE
    };
    let quotient = |t: f64| -> Option<Vec<f64>> {
        let d = near.len();
        let (mut increment, mut outcome) = (vec![0.0; d], [Ok(())]);
        map.stepper(1, &values, epsilon, t / epsilon).increment(
            near,
            &vec![0.0; d],
            &mut increment,
            &mut outcome,
        );
        outcome[0]
            .is_ok()
            .then(|| increment.iter().map(|v| v / t).collect())
    };
    let mut seen = vec![Seen::Nothing; near.len()];
    for k in 0..SIZES {
        let t = largest_step / libm::pow(FINER, f64::from(k));
        let (Some(whole), Some(half)) = (quotient(t), quotient(t / 2.0)) else {
            continue;
        };
        let noise = ROUND_OFF * f64::EPSILON * size / t;
        for i in 0..near.len() {
            let scale = field[i].abs() + whole[i].abs();
            // What round-off hides says nothing.
            if noise <= SAME / 8.0 * scale {
                seen[i].take(2.0 * half[i] - whole[i], field[i], SAME * scale);
            }
        }
    }
    for (i, seen) in seen.iter().enumerate() {
        if let Seen::Other { limit, .. } = seen {
            let name = &system.variables()[i];
            return Err(BuildError::DoesNotFit {
                part,
                reason: format!(
                    "it follows another motion: at the initial state {name} begins to change at the rate \
                     {limit:.6e}, and {{H, {name}}} is {:.6e}; take a part made for this system, or the \
                     system that the part was made for",
                    field[i]
                ),
            });
        }
    }
    Ok(())
}

/// Verdict on the limit of the estimates of a rate so far.
#[derive(Clone, Copy)]
enum Seen {
    /// None yet.
    Nothing,
    /// It tends to the system's.
    Same,
    /// The last estimate, which is none of a limit yet.
    Unsettled { last: f64 },
    /// It tends to another one.
    Other { limit: f64 },
}

impl Seen {
    fn take(&mut self, estimate: f64, expected: f64, tolerance: f64) {
        let off = (estimate - expected).abs();
        *self = match *self {
            Self::Same => Self::Same,
            _ if off <= tolerance => Self::Same,
            Self::Unsettled { last } | Self::Other { limit: last }
                if (estimate - last).abs() <= off / 8.0 =>
            {
                Self::Other { limit: estimate }
            }
            _ => Self::Unsettled { last: estimate },
        };
    }
}

/// ẋ at a state, where it is to be had.
fn field(system: &PoissonSystem, values: &[f64], x: &[f64]) -> Option<Vec<f64>> {
    let map = system.field_values().ok()?;
    let mut field = vec![0.0; x.len()];
    map.evaluator(values, 1.0, 1.0).values(x, &mut field).ok()?;
    field.iter().all(|v| v.is_finite()).then_some(field)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}
