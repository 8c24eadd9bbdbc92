//! Equations of the contract, and derivatives against differences of values.

use crate::smoke_failure::SmokeFailure;

/// Round-off that an equation may have, relative to the numbers in it.
const ROUND_OFF: f64 = 1e-11;

/// The step of central differences, and what their error may be: a derivative that is wrong differs by
/// its own size.
const STEP: f64 = 1e-5;
const DIFFERENCE: f64 = 1e-4;

/// Checks `found = expected`, both vectors, to round-off of numbers of size `scale`.
pub(super) fn equal(
    identity: &str,
    found: &[f64],
    expected: &[f64],
    scale: f64,
) -> Result<(), SmokeFailure> {
    within(
        identity,
        found,
        expected,
        ROUND_OFF * (scale + largest(expected)),
    )
}

/// Checks `found = expected` up to `tolerance`.
pub(super) fn within(
    identity: &str,
    found: &[f64],
    expected: &[f64],
    tolerance: f64,
) -> Result<(), SmokeFailure> {
    let differs = |(a, b): (&f64, &f64)| (a - b).abs() > tolerance;
    if found.iter().zip(expected).any(differs) {
        return Err(SmokeFailure::Identity {
            identity: identity.to_owned(),
            found: found.to_vec(),
            expected: expected.to_vec(),
        });
    }
    Ok(())
}

/// max |v|.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

/// Checks a row-major Jacobian at `point` against central differences of `value`; points where the
/// value is not to be had are left out.
pub(super) fn derivative(
    name: &str,
    jacobian: &[f64],
    point: &[f64],
    mut value: impl FnMut(&[f64]) -> Result<Option<Vec<f64>>, SmokeFailure>,
) -> Result<(), SmokeFailure> {
    let columns = point.len();
    for j in 0..columns {
        let mut shifted = |step: f64| {
            let mut shifted = point.to_vec();
            shifted[j] += step;
            value(&shifted)
        };
        let (Some(up), Some(down)) = (shifted(STEP)?, shifted(-STEP)?) else {
            continue;
        };
        let differences: Vec<f64> = up
            .iter()
            .zip(&down)
            .map(|(a, b)| (a - b) / (2.0 * STEP))
            .collect();
        let column: Vec<f64> = jacobian.iter().skip(j).step_by(columns).copied().collect();
        let identity = format!("{name}, column {}, by differences of values", j + 1);
        let size = 1.0 + largest(&differences) + largest(&up);
        within(&identity, &column, &differences, DIFFERENCE * size)?;
    }
    Ok(())
}
