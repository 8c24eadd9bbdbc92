//! Is a map its own adjoint?

use super::sampled_defect::{MOST_MEASURED, sizes_along};
use super::{one_step, round_off};
use crate::error::StepError;
use crate::solver::StepMap;
use crate::solver::judge::larger;

/// max_i |Φ_{−h}(Φ_h(x)) − x|_i / s_i from cold starts: round-off for a self-adjoint map, Φ_{−h}∘Φ_h = id.
///
/// The unit u s_i is what round-off may put into a coordinate. Round-off of x goes through DΦ_h, that of Φ_h(x)
/// through DΦ_{−h}. Both tangents are taken by differences where a map offers none, of many coordinates along a few
/// random directions. No units of the coordinates change the ratio.
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
    // Φ_{±h}(from), and the sizes of what it puts into the coordinates of arguments of these.
    let step = |h: f64, from: &[f64], arguments: &[f64]| {
        let mut stepper = map.stepper(1, parameters, epsilon, h);
        let mut end = vec![0.0; x.len()];
        one_step::increment(stepper.as_mut(), from, &mut end)?;
        let tangent = match one_step::tangent(stepper.as_mut(), x.len()) {
            None if x.len() <= MOST_MEASURED => {
                let [tangent, _] = one_step::tangent_by_differences(stepper.as_mut(), from)?;
                Some(tangent)
            }
            tangent => tangent,
        };
        end.iter_mut()
            .zip(from)
            .for_each(|(end, from)| *end += from);
        let sizes = match tangent {
            Some(tangent) => round_off::sizes_along(arguments, &end, &tangent),
            None => sizes_along(stepper.as_mut(), from, (arguments, &end))?,
        };
        Ok::<_, StepError>((end, sizes))
    };
    let (there, sizes) = step(h, x, x)?;
    let (back, sizes) = step(-h, &there, &sizes)?;
    let returned = back.iter().zip(x).zip(&sizes);
    let defects = returned.map(|((back, x), size)| match (back - x).abs() {
        0.0 => 0.0,
        off => off / size,
    });
    // A NaN is no small defect.
    Ok(defects.fold(0.0, larger))
}
