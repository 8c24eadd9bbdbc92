//! Is σ a section of both maps?

use super::round_off::sizes;
use crate::code_evaluators::realization_evaluator;
use crate::error::{BuildError, StepError};
use crate::realization::{Ends, RealizationData};
use crate::solver::judge::larger;

/// max |α̂(σ(x)) − x| and max |β̂(σ(x)) − x| over the coordinates, each relative to x_i: the section
/// identity α̂∘σ = β̂∘σ = id. Coordinates that are 0 count in units of the largest.
///
/// # Errors
/// [`BuildError`] when the realization offers no maps; the maps' [`StepError`] inside.
pub fn section_defect(
    realization: &dyn RealizationData,
    parameters: &[f64],
    epsilon: f64,
    x: &[f64],
) -> Result<Result<f64, StepError>, BuildError> {
    let mut evaluator = realization_evaluator(realization, parameters, epsilon)?;
    let mut z = vec![0.0; realization.space_dimension()];
    realization.section(x, &mut z);
    let mut values = vec![0.0; 3 * x.len()];
    if let Err(error) = evaluator.values(&z, &mut values) {
        return Ok(Err(error));
    }
    let ends = Ends::of(&values);
    let sizes = sizes(x);
    let defect = (0..x.len()).fold(0.0_f64, |largest, i| {
        let beta = (ends.base[i] - x[i]) + ends.offset[i];
        let alpha = beta + ends.increment[i];
        [beta, alpha].into_iter().fold(largest, |largest, off| {
            // A NaN is no small defect.
            larger(largest, off.abs() / sizes[i])
        })
    });
    Ok(Ok(defect))
}
