//! Derivatives by differences: for instruments alone, and marked as such.
//!
//! Solvers never use them. An instrument does where a map or a system offers no exact derivative; what
//! it then reports stands beside its floor, the size of the differences' own error.

use nalgebra::DMatrix;

use crate::error::StepError;

/// The largest step relative to a coordinate: the estimated truncation, of order δ⁴, and round-off,
/// u/δ, balance near 1e-12.
const LARGEST: f64 = 1.0 / 256.0;

/// A derivative with an estimate of its error, entry by entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Differences {
    /// DF, outputs × inputs.
    pub jacobian: DMatrix<f64>,
    /// Estimated error of each entry of `jacobian`, outputs × inputs.
    pub error: DMatrix<f64>,
}

/// DF(x) of a map with `outputs` components, by central differences over δ, δ/2 and δ/4 extrapolated to
/// order 6 in δ, each coordinate in steps of its own size.
///
/// The error is the difference of the two slopes of order 4, and the round-off of F over the smallest step. In the
/// mean that difference holds what the map's own noise, such as that of a solve, puts into the slopes.
///
/// # Errors
/// The map's [`StepError`].
pub fn jacobian_by_differences(
    x: &[f64],
    outputs: usize,
    map: impl FnMut(&[f64], &mut [f64]) -> Result<(), StepError>,
) -> Result<Differences, StepError> {
    in_steps_of(x, x, outputs, map)
}

/// The same, each coordinate in steps of a given size; in steps of the largest one where that is 0.
pub(super) fn in_steps_of(
    sizes: &[f64],
    x: &[f64],
    outputs: usize,
    mut map: impl FnMut(&[f64], &mut [f64]) -> Result<(), StepError>,
) -> Result<Differences, StepError> {
    let d = x.len();
    let largest = sizes.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut jacobian = DMatrix::zeros(outputs, d);
    let mut error = DMatrix::zeros(outputs, d);
    let mut point = x.to_vec();
    let mut ends = [vec![0.0; outputs], vec![0.0; outputs]];
    for k in 0..d {
        let size = match (sizes[k] == 0.0, largest == 0.0) {
            (false, _) => sizes[k].abs(),
            (true, false) => largest,
            (true, true) => 1.0,
        };
        let mut slopes = vec![[0.0_f64; 3]; outputs];
        let mut noise = vec![0.0_f64; outputs];
        for (level, factor) in [1.0, 0.5, 0.25].into_iter().enumerate() {
            let step = LARGEST * factor * size;
            let (ahead, behind) = (x[k] + step, x[k] - step);
            for (at, end) in [ahead, behind].into_iter().zip(&mut ends) {
                point[k] = at;
                map(&point, end)?;
            }
            point[k] = x[k];
            for i in 0..outputs {
                let [ahead_value, behind_value] = [ends[0][i], ends[1][i]];
                slopes[i][level] = (ahead_value - behind_value) / (ahead - behind);
                let size = ahead_value.abs().max(behind_value.abs());
                noise[i] = 4.0 * f64::EPSILON * size / step;
            }
        }
        for (i, [whole, half, quarter]) in slopes.into_iter().enumerate() {
            let coarse = half + (half - whole) / 3.0;
            let fine = quarter + (quarter - half) / 3.0;
            jacobian[(i, k)] = fine + (fine - coarse) / 15.0;
            error[(i, k)] = (fine - coarse).abs() + noise[i];
        }
    }
    Ok(Differences { jacobian, error })
}

#[cfg(test)]
mod tests {
    use super::jacobian_by_differences;

    /// F(x, y) = (x y², exp(x/y)): derivatives of every order, coordinates of different sizes.
    #[test]
    fn the_error_is_covered_by_its_estimate_and_near_round_off() {
        for x in [[0.7, -1.3], [3.0e8, 2.0e8], [0.0, 4.0]] {
            let found = jacobian_by_differences(&x, 2, |at, out| {
                out[0] = at[0] * at[1] * at[1];
                out[1] = libm::exp(at[0] / at[1]);
                Ok(())
            })
            .expect("a smooth map");
            let [a, b] = x;
            let e = libm::exp(a / b);
            let exact = [[b * b, 2.0 * a * b], [e / b, -a / (b * b) * e]];
            for i in 0..2 {
                for k in 0..2 {
                    let error = (found.jacobian[(i, k)] - exact[i][k]).abs();
                    let estimate = found.error[(i, k)];
                    assert!(error <= estimate, "{x:?}: {error:e} > {estimate:e}");
                    // δ⁴/480 times the fifth derivative, 822 times the first of exp(1.5/t) at t = 1; and
                    // u/δ.
                    let largest = exact[i][0].abs().max(exact[i][1].abs());
                    assert!(estimate <= 1e-9 * largest, "{x:?}: {estimate:e}");
                }
            }
        }
    }

    /// A coordinate that is 0 is varied in its own unit, however small beside the others'.
    #[test]
    fn no_coordinate_is_varied_by_the_size_of_another() {
        let (x, unit) = ([1.0, 0.0], 1e-36);
        let found = super::in_steps_of(&[1.0, unit], &x, 1, |at, out| {
            assert!((at[0] - 1.0).abs() <= super::LARGEST && at[1].abs() <= super::LARGEST * unit);
            out[0] = libm::cos(at[0]) * (1.0 + at[1] / unit);
            Ok(())
        });
        let found = found.expect("a smooth map");
        for (k, exact) in [-libm::sin(1.0), libm::cos(1.0) / unit]
            .into_iter()
            .enumerate()
        {
            let error = (found.jacobian[k] - exact).abs();
            assert!(error <= found.error[k] && found.error[k] <= 1e-9 * exact.abs());
        }
    }

    /// A solve that stops at 1e-12 puts that into the values, and a thousand times as much into slopes. At
    /// a point two slopes may agree by chance, in the mean over many they do not.
    #[test]
    fn the_noise_of_a_map_is_in_the_estimate() {
        let (mut errors, mut estimates) = (0.0, 0.0);
        for k in 0..50 {
            let x = 1.0 + 0.01 * f64::from(k);
            let found = jacobian_by_differences(&[x], 1, |at, out| {
                out[0] = at[0] + 1e-12 * libm::sin(1e9 * at[0]);
                Ok(())
            })
            .expect("a map");
            errors += (found.jacobian[0] - 1.0).abs();
            estimates += found.error[0];
        }
        assert!(errors <= 2.0 * estimates, "{errors:e} > 2 * {estimates:e}");
    }
}
