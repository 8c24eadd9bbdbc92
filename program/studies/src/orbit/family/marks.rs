//! Marks between two orbits of a family: where functions along it change their sign.

use super::super::OrbitError;
use super::super::linear::dot;
use super::super::multipliers::meet_on_the_circle;
use super::types::Mark;
use super::{Continued, DISCRIMINANT, FOLD, MINUS, PLUS, Walk};

/// Trials of one mark, at most.
const TRIALS: usize = 40;

/// The part of a step to which a mark is found.
const FOUND: f64 = 1e-10;

/// Test functions that never exceed this are zero along the family.
const ZERO: f64 = 1e-7;

/// The least singular value that counts falls to this part of its neighbours' where families meet.
const MEETS: f64 = 1e-2;

/// The size of an orbit at an equilibrium, at most, over those on both sides of it.
const SHRINKS: f64 = 1e-2;

impl Walk<'_> {
    /// Marks between two orbits, in their order.
    pub(super) fn marks(
        &mut self,
        here: &Continued,
        next: &Continued,
    ) -> Result<Vec<(Mark, Continued)>, OrbitError> {
        let mut found = Vec::new();
        let changes = |which: usize| {
            let [a, b] = [here.tests[which], next.tests[which]];
            a * b < 0.0 && (which == FOLD || a.abs().max(b.abs()) > ZERO)
        };
        let folds = changes(FOLD);
        if folds {
            let (at, point) = self.located(here, next, FOLD)?;
            // Behind an equilibrium the orbits begin anew, half a turn on.
            if point.moved < SHRINKS * here.moved.min(next.moved) {
                return Err(OrbitError::Equilibrium {
                    iterations: point.orbit.iterations,
                    moved: point.moved,
                });
            }
            found.push(((at, point), Mark::Fold));
        }
        if changes(PLUS) {
            let (at, point) = self.located(here, next, PLUS)?;
            let mark = match point.least < MEETS * here.least.max(next.least) {
                true => Some(Mark::Branch),
                false => (!folds).then_some(Mark::EnergyFold),
            };
            found.extend(mark.map(|mark| ((at, point), mark)));
        }
        if changes(MINUS) {
            found.push((self.located(here, next, MINUS)?, Mark::Doubling));
        }
        if changes(DISCRIMINANT) {
            let (at, point) = self.located(here, next, DISCRIMINANT)?;
            if meet_on_the_circle(&point.orbit.multipliers) {
                found.push(((at, point), Mark::Krein));
            }
        }
        found.sort_by(|((a, _), _), ((b, _), _)| a.total_cmp(b));
        let marks = found.into_iter().map(|((_, point), mark)| (mark, point));
        Ok(marks.collect())
    }

    /// Where a test function is zero between two orbits: by the secants of Illinois.
    fn located(
        &mut self,
        here: &Continued,
        next: &Continued,
        which: usize,
    ) -> Result<(f64, Continued), OrbitError> {
        let pairs = next.unknowns.iter().zip(&here.unknowns);
        let moved: Vec<f64> = pairs.map(|(b, a)| b - a).collect();
        let whole = dot(&here.tangent, &moved);
        let (mut low, mut high) = ((0.0, here.tests[which]), (whole, next.tests[which]));
        let mut best: Option<(f64, Continued)> = None;
        for _ in 0..TRIALS {
            let at = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            let point = self.stepped(here, at)?;
            let value = point.tests[which];
            let is_better = match &best {
                None => true,
                Some((_, best)) => value.abs() < best.tests[which].abs(),
            };
            let ends = (at - low.0).abs().min((high.0 - at).abs()) <= FOUND * whole.abs();
            if is_better {
                best = Some((at, point));
            }
            if value == 0.0 || ends {
                break;
            }
            if value * high.1 < 0.0 {
                low = high;
            } else {
                low.1 *= 0.5;
            }
            high = (at, value);
        }
        best.ok_or(OrbitError::NotClosed {
            iterations: TRIALS,
            closure: f64::NAN,
        })
    }
}
