//! Agreement of code that exact algebra made of formulas with the formulas themselves.
//!
//! Sums expanded in exact algebra are right and may still be useless in doubles: of (q − 1000)⁴ nothing
//! is left but the round-off of 10¹². And no algebra is trusted blindly. Both show in numbers: code made
//! by way of the algebra is evaluated at points beside code of the formulas, each with a bound on its
//! rounding errors.

use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::{Graph, Term};

use super::SystemFormulas;

/// How two codes for the same functions compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agreement {
    /// Their values agree to round-off, which is of the same size in both.
    Same,
    /// Their values agree, but round-off of the first is far larger: its sums cancel.
    Cancels,
    /// Their values differ.
    Differs,
}

/// Round-off that is so many times larger is reported as cancellation. Expansions that serve lose two
/// digits at most; of shifted powers less than half the digits are left.
const CANCELLATION: f64 = 4096.0;

/// Differences within so many of the bounds are round-off.
const WITHIN: f64 = 4.0;

/// Points away from the reference point, relative to its coordinates: those that are near tell
/// cancellation, and all of them what differs.
const DISTANCES: [f64; 5] = [0.0, 1e-3, -1e-3, 0.1, -0.1];
const NEAR: usize = 3;

impl SystemFormulas {
    /// `made` against `expected`, codes of the same functions in the state, at
    /// [the reference point](Self::near) and points about it, at the parameters' values. Points where
    /// `expected` has no finite values are left out.
    pub fn agreement(&self, graph: &Graph, made: &[Term], expected: &[Term]) -> Agreement {
        self.agreement_of_parts(graph, made, expected, |_| 1.0)
    }

    /// The same for parts of a sum, the part with this index at most `share` of the whole: its round-off
    /// counts in that proportion.
    pub fn agreement_of_parts(
        &self,
        graph: &Graph,
        made: &[Term],
        expected: &[Term],
        share: impl Fn(usize) -> f64,
    ) -> Agreement {
        let mut numbers = BoundedNumbers {
            parameters: self.parameter_values(),
        };
        let all: Vec<Term> = made.iter().chain(expected).cloned().collect();
        // The largest bounds near the reference point, of what was made and of what is expected.
        let mut errors = vec![(0.0_f64, 0.0_f64); made.len()];
        for (at, x) in self.points().iter().enumerate() {
            let Ok(values) = numbers.values(graph, &all, x) else {
                continue;
            };
            let (made, expected) = values.split_at(made.len());
            if expected
                .iter()
                .any(|e| !e.value.is_finite() || !e.error.is_finite())
            {
                continue;
            }
            for ((m, e), errors) in made.iter().zip(expected).zip(&mut errors) {
                let own = e.error.max(f64::EPSILON * e.value.abs());
                // NaN is not within any bound.
                let agrees = (m.value - e.value).abs() <= WITHIN * (m.error + own);
                if !agrees {
                    return Agreement::Differs;
                }
                if at < NEAR {
                    *errors = (errors.0.max(m.error), errors.1.max(own));
                }
            }
        }
        let cancels = |(at, &(made, expected)): (usize, &(f64, f64))| {
            share(at) * made > CANCELLATION * expected
        };
        if errors.iter().enumerate().any(cancels) {
            Agreement::Cancels
        } else {
            Agreement::Same
        }
    }

    /// Whether sums that are 0 in exact algebra are 0 to round-off at the same points.
    pub(crate) fn are_zero(&self, graph: &Graph, sums: &[Term]) -> bool {
        let mut numbers = BoundedNumbers {
            parameters: self.parameter_values(),
        };
        self.points().iter().all(|x| {
            let values = numbers.values(graph, sums, x).unwrap_or_default();
            let is_zero = |v: &Bounded| {
                !v.value.is_finite() || !v.error.is_finite() || v.value.abs() <= WITHIN * v.error
            };
            values.iter().all(is_zero)
        })
    }

    /// The reference point and points about it: a coordinate at 0 moves in proportion to the largest.
    pub fn points(&self) -> Vec<Vec<f64>> {
        let near = self.near();
        let largest = near.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let mut phase = 0.5_f64;
        let mut next = move || {
            phase = (phase + 0.618_033_988_749_894_9) % 1.0;
            0.5 + phase
        };
        let moved = |distance: &f64| {
            let near = near.iter();
            near.map(|x| {
                let size = if *x == 0.0 { scale } else { *x };
                x + size * distance * next()
            })
            .collect()
        };
        DISTANCES.iter().map(moved).collect()
    }
}
