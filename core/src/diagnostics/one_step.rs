//! One step from a cold start, and its derivative.

use nalgebra::DMatrix;

use super::differences::in_steps_of;
use crate::error::StepError;
use crate::solver::Stepper;

/// Φ(x) − x, cold.
pub(super) fn increment(
    stepper: &mut dyn Stepper,
    x: &[f64],
    increment: &mut [f64],
) -> Result<(), StepError> {
    let mut outcome = [Ok(())];
    stepper.restart();
    stepper.increment(x, &vec![0.0; x.len()], increment, &mut outcome);
    let [outcome] = outcome;
    outcome
}

/// DΦ of the step taken last.
pub(super) fn tangent(stepper: &mut dyn Stepper, dimension: usize) -> Option<DMatrix<f64>> {
    let rows = stepper.tangent(0)?;
    Some(DMatrix::from_row_slice(dimension, dimension, &rows))
}

/// DΦ(x) by differences of cold steps, and what they may be wrong by.
pub(super) fn tangent_by_differences(
    stepper: &mut dyn Stepper,
    x: &[f64],
) -> Result<[DMatrix<f64>; 2], StepError> {
    let d = x.len();
    // A coordinate that passes 0 has the size of its change: others may have units in which it is tiny.
    let mut sizes = vec![0.0; d];
    increment(stepper, x, &mut sizes)?;
    for (size, x) in sizes.iter_mut().zip(x) {
        *size = size.abs().max(x.abs());
    }
    // Differences of increments: those of states would bring the states' round-off.
    let change = in_steps_of(&sizes, x, d, |at, out| increment(stepper, at, out))?;
    Ok([DMatrix::identity(d, d) + change.jacobian, change.error])
}
