//! Coordinates whose sign a Poisson map keeps.

use leafwise_expression::{Arithmetic, Ring};

use leafwise_solver::{Checked, StepCheck, Stepper};

use crate::error::StepError;
use crate::system::PoissonSystem;

/// Smallest part of a coordinate that a step may leave; with less, the coordinate has lost its digits. Then x + Δ
/// keeps the sum's round-off, of the size of x, which is more than 1/4096 of what is left.
const LEAST_PART: f64 = 1.0 / (1_u64 << 40) as f64;

/// Below this a number has not all its digits, and is left to underflow.
const SMALLEST: f64 = 1e-290;

/// Coordinates x_i for which {x_i, x_j} vanishes at x_i = 0 for all j, as in a Lotka–Volterra system. The hyperplane
/// consists of leaves, and a Poisson map near the flow does not cross it. None of a tensor that the exact ring does
/// not hold.
pub fn kept_signs(system: &PoissonSystem) -> Vec<usize> {
    let Some(formulas) = system.expressions() else {
        return Vec::new();
    };
    let mut ring = Ring::new(formulas.dimension());
    let mut vanishes = |i: usize| {
        let entries = formulas.tensor().iter();
        let mut own = entries.filter(|((a, b), _)| *a == i || *b == i).peekable();
        own.peek().is_some()
            && own.all(|(_, entry)| {
                let value = entry.evaluate_in(&mut ring, &mut |ring: &mut Ring, at| {
                    let x = ring.variable(at);
                    Ok(if at == i { ring.subtract(&x, &x) } else { x })
                });
                value.is_ok_and(|value| ring.is_zero(&value))
            })
    };
    (0..formulas.dimension()).filter(|i| vanishes(*i)).collect()
}

/// A stepper that refuses steps in which one of these coordinates loses its sign, or its digits: see [`kept_signs`].
pub fn keeping_signs(stepper: Box<dyn Stepper>, signs: &[usize]) -> Box<dyn Stepper> {
    match signs {
        [] => stepper,
        signs => Checked::boxed(stepper, Box::new(KeptSigns(signs.to_vec()))),
    }
}

/// Each of these coordinates keeps its sign.
struct KeptSigns(Vec<usize>);

impl StepCheck for KeptSigns {
    fn reads(&self, coordinate: usize) -> bool {
        self.0.contains(&coordinate)
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let lanes = outcome.len();
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            let is_lost = |coordinate: &usize| {
                let at = coordinate * lanes + lane;
                is_lost(x[at], increment[at])
            };
            // Of all without a jump, which none takes as a rule.
            let is_any = self.0.iter().fold(false, |any, at| any | is_lost(at));
            if !is_any || outcome.is_err() {
                continue;
            }
            if let Some(lost) = self.0.iter().find(|at| is_lost(at)) {
                *outcome = Err(StepError::LostSign {
                    coordinate: lost + 1,
                });
            }
        }
    }
}

/// Whether x + Δ has not the sign of x, or none of its digits.
#[inline(always)]
fn is_lost(x: f64, change: f64) -> bool {
    let after = x + change;
    let part = if x.is_sign_negative() { -after } else { after };
    let keeps = part >= LEAST_PART * x.abs();
    !keeps & (x.abs() > SMALLEST)
}
