//! Convergence of a linear iteration, judged by its corrections.

use crate::error::StepError;

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
/// It stops when what the next correction would add is below 1/32 of a unit roundoff, judged by
/// the observed rate, or when the corrections stagnate at round-off.
#[derive(Clone, Copy, Debug)]
pub struct LinearIteration {
    last: f64,
    evaluations: usize,
    most: usize,
}

impl LinearIteration {
    /// A fresh iteration with a budget of evaluations.
    pub fn new(most: usize) -> Self {
        Self {
            last: f64::INFINITY,
            evaluations: 0,
            most,
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
        if converged || stagnates || size == 0.0 {
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
