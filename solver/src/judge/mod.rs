//! When an iteration is done: the rules that every solve shares.
//!
//! A solve ends where the remainder of its last correction is negligible, or where corrections no
//! longer shrink because they are round-off. The two are told apart by all corrections so far: a slow
//! linear iteration falls below its smallest correction again and again, round-off does not, however
//! regularly it repeats. Solves come here by an [`Iteration`](crate::Iteration); Newton's method by kernels
//! predicts remainders instead (`newton/convergence.rs`), from sizes that are measured here.

mod linear;
mod measures;
mod numbers;
mod reached;
mod watch;

pub(crate) use linear::LinearIteration;
pub use linear::Verdict;
pub use measures::{
    Allowed, CorrectionSize, at_least, is_between, larger, largest, ratio_in_own_units, reach,
    relative, settled,
};
pub use numbers::at_most;
pub(crate) use numbers::{Doubles, Numbers, SMALLEST_SCALE, relative_size, scale_beside};
pub use reached::LinearSolve;
pub(crate) use reached::Reached;
pub(super) use watch::WANDERING;
pub use watch::Watch;

use crate::error::StepError;

/// The largest relative remainder that ends a solve: 1/512 of a unit roundoff. Unlike rounding it has
/// a sign, which depends on where the orbit is, and adds up in proportion to the steps. With sixteen
/// times this, and a quarter of the safety, `leafwise stress long --long` found the rigid body's
/// Casimir 1.9e-12 off after 10⁸ steps, growing like steps^0.61; with this 3.1e-13, like steps^0.47.
pub(super) const LARGEST_REMAINDER: f64 = f64::EPSILON / 1024.0;

/// A correction this small beside the whole state is round-off of its largest component.
pub(super) const NORMWISE_ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Corrections up to this size are round-off where two in a row are not the smallest so far.
pub(crate) const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Corrections up to this size are round-off where one is not the smallest so far.
pub(super) const ULPS: f64 = 4.0 * f64::EPSILON;

/// Refuses an equation's residual and Jacobian where a number of them is not finite.
///
/// # Errors
/// [`StepError::NonFinite`].
pub fn all_finite(residual: &[f64], jacobian: &[f64], what: &'static str) -> Result<(), StepError> {
    match residual.iter().chain(jacobian).all(|v| v.is_finite()) {
        true => Ok(()),
        false => Err(StepError::NonFinite { what }),
    }
}

/// Refuses a point whose guard is not below 1. The guard is the last term of a series over the first, or a radius
/// over its limit.
///
/// # Errors
/// [`StepError::LeftChart`], [`StepError::NonFinite`] where the guard is no number.
pub fn inside_chart(ratio: f64) -> Result<(), StepError> {
    if ratio < 1.0 {
        return Ok(());
    }
    Err(if ratio.is_nan() {
        StepError::NonFinite {
            what: "the distance to the edge of the realization's chart",
        }
    } else {
        StepError::LeftChart { ratio }
    })
}
