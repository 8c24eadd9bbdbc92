//! Is a map its own adjoint?

use crate::error::StepError;
use crate::integrator::Integrator;
use crate::solver::StepMap;

/// ‖Φ_{−h}(Φ_h(x)) − x‖_∞ / ‖x‖_∞ from cold starts: round-off for a self-adjoint map, for which
/// Φ_{−h}∘Φ_h = id.
///
/// # Errors
/// The map's [`StepError`].
pub fn self_adjointness_defect(
    map: &dyn StepMap,
    parameters: &[f64],
    epsilon: f64,
    h: f64,
    x: &[f64],
) -> Result<f64, StepError> {
    let mut there = Integrator::new(map, parameters, epsilon, h, x);
    there.step()?;
    let mut back = Integrator::new(map, parameters, epsilon, -h, there.state());
    back.step()?;
    let size = x.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let distance = |(a, b): (&f64, &f64)| (a - b).abs();
    Ok(back.state().iter().zip(x).map(distance).fold(0.0, f64::max) / size)
}
