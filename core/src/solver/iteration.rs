//! Convergence of a linear iteration, judged by its corrections.

use crate::error::StepError;

/// A correction this small beside the whole state is round-off of its largest component.
pub(super) const NORMWISE_ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// The size of a correction, component by component and as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorrectionSize {
    component: f64,
    largest: f64,
    state: f64,
}

impl CorrectionSize {
    /// Takes in a component's correction and the scale it is judged against, the size of the state
    /// there and of what is added to it. A component that has no scale yet counts as 1.
    pub fn take(&mut self, correction: f64, scale: f64) {
        let size = correction.abs();
        if size != 0.0 {
            self.component = larger(self.component, size / (scale + size));
        }
        self.largest = larger(self.largest, size);
        self.state = larger(self.state, scale);
    }

    /// The largest relative correction of a component, at most 1; NaN where one is not finite.
    pub fn component(&self) -> f64 {
        self.component
    }

    /// The largest correction over the largest scale.
    pub fn norm(&self) -> f64 {
        if self.largest == 0.0 {
            0.0
        } else {
            self.largest / self.state
        }
    }
}

/// max that keeps NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// What to do after a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Go on.
    Continue,
    /// What further corrections would add is negligible.
    Converged,
}

/// Watches the sizes of the corrections of a linearly convergent iteration.
///
/// It stops when what the next correction would add is below 1/512 of a unit roundoff, judged by
/// the observed rate, or when the corrections stagnate at round-off.
#[derive(Clone, Copy, Debug)]
pub struct LinearIteration {
    last: f64,
    evaluations: usize,
    most: usize,
    stuck: usize,
}

impl LinearIteration {
    /// A fresh iteration with a budget of evaluations.
    pub fn new(most: usize) -> Self {
        Self {
            last: f64::INFINITY,
            evaluations: 0,
            most,
            stuck: 0,
        }
    }

    /// Evaluations so far.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Takes in a correction's size, the largest relative change of a component.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] for a size that is not finite, [`StepError::NoConvergence`] when
    /// the budget is spent.
    pub fn judge(&mut self, size: f64) -> Result<Verdict, StepError> {
        self.judge_state(size, f64::INFINITY)
    }

    /// Takes in the sizes of a correction of a state, whose components may be round-off of larger
    /// ones: where they stop to shrink and the whole is at round-off, nothing more is to be had.
    ///
    /// # Errors
    /// Those of [`judge`](Self::judge).
    pub fn judge_correction(&mut self, correction: &CorrectionSize) -> Result<Verdict, StepError> {
        self.judge_state(correction.component, correction.norm())
    }

    fn judge_state(&mut self, size: f64, norm: f64) -> Result<Verdict, StepError> {
        self.evaluations += 1;
        if !size.is_finite() {
            return Err(StepError::NonFinite {
                what: "a correction",
            });
        }
        // Without an observed rate the correction itself has to be negligible.
        let rate = if self.last.is_finite() {
            size / self.last
        } else {
            1.0
        };
        let converged = size * rate.min(1.0) <= super::LARGEST_REMAINDER;
        let stagnates = size >= 0.5 * self.last && size <= 64.0 * f64::EPSILON;
        self.stuck = if size >= 0.5 * self.last {
            self.stuck + 1
        } else {
            0
        };
        let is_round_off = self.stuck >= 2 && norm <= NORMWISE_ROUND_OFF;
        if converged || stagnates || is_round_off || size == 0.0 {
            return Ok(Verdict::Converged);
        }
        if self.evaluations >= self.most {
            return Err(StepError::NoConvergence {
                evaluations: self.evaluations,
                correction: size,
            });
        }
        self.last = size;
        Ok(Verdict::Continue)
    }
}
