//! The ends α, β and the identities of a dual pair.

use std::sync::Arc;

use leafwise_core::diagnostics::RealizationInstrument;
use leafwise_core::{Ends, PoissonSystem, RealizationData, StepError, realization_worker};

use nalgebra::DMatrix;

use crate::largest;

/// The base x, β − x and α − β at a point of S, by the realization's code or numbers: see [`Ends`].
///
/// # Errors
/// The realization's [`StepError`].
///
/// # Panics
/// When it offers neither.
pub fn ends(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    epsilon: f64,
    z: &[f64],
) -> Result<Vec<f64>, StepError> {
    let mut worker = realization_worker(realization, &system.parameter_values(), epsilon)
        .expect("maps of some kind");
    let mut ends = vec![0.0; 3 * system.dimension()];
    worker.values(z, &mut ends)?;
    Ok(ends)
}

/// α and β at (x, p).
///
/// # Errors
/// The realization's [`StepError`].
pub fn source_and_target(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    epsilon: f64,
    x: &[f64],
    p: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), StepError> {
    let ends = ends(system, realization, epsilon, &[x, p].concat())?;
    let ends = Ends::of(&ends);
    Ok((0..x.len())
        .map(|i| (ends.source(i), ends.target(i)))
        .unzip())
}

/// The largest of ε Π(α) − {α, α}, ε Π(β) + {β, β} and {α, β} over the largest summand of the
/// brackets, Σ_k |∂f/∂x^k| |∂g/∂p_k|.
///
/// # Errors
/// The realization's [`StepError`].
///
/// # Panics
/// When the realization has no maps on T*M.
pub fn dual_pair_error(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    epsilon: f64,
    x: &[f64],
    p: &[f64],
) -> Result<f64, StepError> {
    let parameters = system.parameter_values();
    let mut instrument =
        RealizationInstrument::new(system, realization, &parameters).expect("maps on T*M");
    let error = instrument.measure(epsilon, x, p)?;
    let mut worker = realization_worker(realization.as_ref(), &parameters, epsilon).expect("maps");
    let d = x.len();
    let mut tangents = vec![0.0; 4 * d * d];
    worker.jacobians(&[x, p].concat(), &mut tangents)?;
    let (target, increment) = tangents.split_at(2 * d * d);
    let target = DMatrix::from_row_slice(d, 2 * d, target);
    let source = &target + DMatrix::from_row_slice(d, 2 * d, increment);
    let summands = [&source, &target].map(|map| {
        let map = map.abs();
        (map.columns(0, d) * map.columns(d, d).transpose()).max()
    });
    let scale = largest(summands).max(error.scale);
    Ok(largest([error.source, error.target, error.dual_pair]) / scale)
}

/// The larger of |β(x, p) − α(x, −p)| and |α(σ(x)) − x|, |β(σ(x)) − x| over the size of x.
///
/// # Errors
/// The realization's [`StepError`].
pub fn inversion_and_section_error(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    epsilon: f64,
    x: &[f64],
    p: &[f64],
) -> Result<f64, StepError> {
    let minus: Vec<f64> = p.iter().map(|p| -p).collect();
    let (alpha, beta) = source_and_target(system, realization, epsilon, x, p)?;
    let (source, target) = source_and_target(system, realization, epsilon, x, &minus)?;
    let mut z = vec![f64::NAN; realization.space_dimension()];
    realization.section(x, &mut z);
    let fixed = ends(system, realization, epsilon, &z)?;
    let size = largest(alpha.iter().chain(&beta).chain(x).copied());
    let fixed = Ends::of(&fixed);
    let section = fixed.base.iter().zip(x).map(|(b, x)| b - x);
    let section = section.chain(fixed.offset.iter().chain(fixed.increment).copied());
    let inversion = crate::distance(&beta, &source).max(crate::distance(&alpha, &target));
    Ok(largest(section).max(inversion) / size)
}
