//! An order with a tolerance that follows from the points.

use nalgebra::{DMatrix, DVector};

/// An exponent fitted to errors, and how far it may lie from the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedOrder {
    /// q in error ≈ c·t^q (1 + k t^r + …).
    pub exponent: f64,
    /// Tolerance of the exponent: how far misfit, round-off and the terms left out may move it.
    pub tolerance: f64,
    /// How many points the fit holds.
    pub points: usize,
}

/// Errors up to this multiple of round-off are dropped.
const MARGIN: f64 = 4.0;

/// How well a logarithm is expected to be met where there is no round-off.
const MISFIT: f64 = 0.01;

/// The most that the slope may differ between the coarsest point of a window and its limit.
const LARGEST_BEND: f64 = 1.0;

/// Five coefficients at most, and a degree of freedom.
const FEWEST: usize = 6;

/// Fits ln error = a + q ln t + k t^r to points (t, error) in any order. The exponent r of the next term is `gap`,
/// and `round_off` bounds what rounding puts into an error.
///
/// Errors far above round-off may be pre-asymptotic, those near it are noise, and with a high order few lie between.
/// So the next term is fitted as well, and points weigh by their noise. The tolerance is derived, not chosen, as the
/// sum of two parts:
///
/// - A fit is linear, q = Σ wᵢ ln eᵢ. So round-off, independent from step to step, moves q by √Σ (wᵢ round_off/eᵢ)².
///   The tolerance holds three times that, or three of the standard errors that the misfit gives.
/// - The next terms are left out. They move q by at most twice what one or two more of them do. This holds as long as
///   each moves q by at most half of what the ones before did.
///
/// Of the windows that hold the finest points, the one with the smallest tolerance is taken. Windows over which the
/// slope bends by more than one order are pre-asymptotic and are left out. Returns `None` where no window is left,
/// such as with fewer than six points above four times round-off.
pub fn fit_order(points: &[(f64, f64)], round_off: f64, gap: f64) -> Option<FittedOrder> {
    let kept = above_round_off(points, round_off);
    (FEWEST..=kept.len())
        .filter_map(|count| fit(&kept[..count], round_off, gap))
        .min_by(|a, b| a.tolerance.total_cmp(&b.tolerance))
}

/// Smallest slope of ln error over ln t near the finest points above round-off, whatever rounding does to them.
/// Slopes are taken between any two points that are half an octave apart or more, both within an octave and a half of
/// the finest. The smallest is a lower bound of the order as far as it can be seen. It serves where too few points
/// are left for a fit, or where powers of t do not describe them. Returns `None` with no such pair.
pub fn least_slope(points: &[(f64, f64)], round_off: f64) -> Option<f64> {
    let kept = above_round_off(points, round_off);
    let finest = kept.first()?.0;
    let near = kept.iter().take_while(|(t, _)| *t <= 3.0 * finest);
    let pairs = near.flat_map(|coarse| kept.iter().map(move |fine| (fine, coarse)));
    pairs
        .filter(|(fine, coarse)| coarse.0 * coarse.0 >= 1.9 * fine.0 * fine.0)
        .map(|(fine, coarse)| {
            let fall = (coarse.1 - round_off) / (fine.1 + round_off);
            libm::log(fall) / libm::log(coarse.0 / fine.0)
        })
        .min_by(f64::total_cmp)
}

/// Points whose errors tell more than round-off, by ascending t.
fn above_round_off(points: &[(f64, f64)], round_off: f64) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = points
        .iter()
        .filter(|(t, e)| *e > MARGIN * round_off && e.is_finite() && *t > 0.0)
        .copied()
        .collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    kept
}

fn fit(window: &[(f64, f64)], round_off: f64, gap: f64) -> Option<FittedOrder> {
    let model = Model::new(window, round_off, gap, 1)?;
    let finer = Model::new(window, round_off, gap, 2)?.coefficients();
    let finest = Model::new(window, round_off, gap, 3)?.coefficients();
    let exponent = model.coefficients()[1];
    // The slope q + Σ j r k_j t^{jr} where t = 1.
    let bend = gap * (finer[2] + 2.0 * finer[3]);
    let bias = [finer[1], finest[1]].map(|q| (q - exponent).abs());
    let weights = model.weights(1);
    let squares = |scale: &dyn Fn(usize) -> f64| -> f64 {
        let scaled = weights.iter().enumerate().map(|(i, w)| w * scale(i));
        scaled.map(|w| w * w).sum()
    };
    let freedom = (window.len() - 3) as f64;
    let standard_error = libm::sqrt(model.misfit() / freedom * squares(&|_| 1.0));
    let noise = libm::sqrt(squares(&|i| round_off / window[i].1 / model.deviations[i]));
    let tolerance = 3.0 * standard_error.max(noise) + 2.0 * bias[0].max(bias[1]);
    (tolerance.is_finite() && bend.abs() <= LARGEST_BEND).then_some(FittedOrder {
        exponent,
        tolerance,
        points: window.len(),
    })
}

/// Least squares with the columns 1, ln t, t^r, …, t^{r·terms}, t in units of the largest.
struct Model {
    /// The expected deviation of each logarithm.
    deviations: Vec<f64>,
    /// ln eᵢ in units of its deviation.
    logs: DVector<f64>,
    /// An orthonormal basis of what the model can say.
    basis: DMatrix<f64>,
    /// Coefficients from components in the basis.
    inverse: DMatrix<f64>,
}

impl Model {
    fn new(window: &[(f64, f64)], round_off: f64, gap: f64, terms: usize) -> Option<Self> {
        let largest = window.last()?.0;
        let deviations: Vec<f64> = window.iter().map(|(_, e)| MISFIT + round_off / e).collect();
        let columns = DMatrix::from_fn(window.len(), terms + 2, |row, column| {
            let t = window[row].0 / largest;
            let value = match column {
                0 => 1.0,
                1 => libm::log(t),
                power => libm::pow(t, gap * (power - 1) as f64),
            };
            value / deviations[row]
        });
        let logs = window.iter().zip(&deviations);
        let logs: Vec<f64> = logs
            .map(|((_, e), deviation)| libm::log(*e) / deviation)
            .collect();
        let qr = columns.qr();
        Some(Self {
            deviations,
            logs: DVector::from_vec(logs),
            basis: qr.q(),
            inverse: qr.r().try_inverse()?,
        })
    }

    /// w with coefficient = Σ wᵢ · logsᵢ.
    fn weights(&self, coefficient: usize) -> Vec<f64> {
        let row = self.inverse.row(coefficient) * self.basis.transpose();
        row.iter().copied().collect()
    }

    fn coefficients(&self) -> Vec<f64> {
        let components = self.basis.transpose() * &self.logs;
        (&self.inverse * components).as_slice().to_vec()
    }

    /// Σ (logsᵢ − model)².
    fn misfit(&self) -> f64 {
        let rest = &self.logs - &self.basis * (self.basis.transpose() * &self.logs);
        rest.norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::{fit_order, least_slope};

    /// Steps an eighth of an octave apart.
    fn errors(count: u32, error: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let step = |k| libm::exp2(-0.125 * f64::from(k));
        (0..count).map(|k| (step(k), error(step(k)))).collect()
    }

    #[test]
    fn a_power_law_has_its_exponent() {
        let fitted = fit_order(&errors(40, |t| 3.0 * t * t * t), 1e-16, 1.0).expect("20 points");
        assert!(
            (fitted.exponent - 3.0).abs() <= fitted.tolerance + 1e-12,
            "{fitted:?}"
        );
        assert!(fitted.tolerance < 1e-10, "{fitted:?}");
        assert!(fit_order(&errors(40, |t| t), 1.0, 1.0).is_none());
    }

    /// e = t⁹ e^{−2t}: slopes from 7 at t = 1 to 9 at 0, of which the last decades are noise.
    #[test]
    fn a_pre_asymptotic_range_is_seen_through() {
        let noise = |t: f64| 1e-13 * libm::sin(1e4 * t);
        let points = errors(48, |t| libm::pow(t, 9.0) * libm::exp(-2.0 * t) + noise(t));
        let fitted = fit_order(&points, 1e-13, 1.0).expect("points above round-off");
        assert!(
            (fitted.exponent - 9.0).abs() <= fitted.tolerance,
            "{fitted:?}"
        );
        assert!(fitted.tolerance < 0.5, "{fitted:?}");
    }

    /// The exponent stays within its tolerance whatever the next terms are, and the tolerance tells
    /// neighbouring orders apart.
    #[test]
    fn the_tolerance_holds_the_terms_left_out() {
        let next = [(-0.6, 0.3), (0.5, 0.5), (3.0, 1.0), (-2.0, 4.0), (0.0, 2.0)];
        for q in 1..=12 {
            for (k1, k2) in next {
                let error = |t: f64| libm::pow(t, f64::from(q)) * (1.0 + k1 * t + k2 * t * t);
                let fitted = fit_order(&errors(80, error), 1e-15, 1.0).expect("points");
                let off = (fitted.exponent - f64::from(q)).abs();
                assert!(off <= fitted.tolerance, "{q} {k1} {k2}: {fitted:?}");
                assert!(fitted.tolerance < 0.5, "{q} {k1} {k2}: {fitted:?}");
            }
        }
    }

    /// Slopes that fall from 11 to 8, where round-off takes up to half an order. One less is seen.
    #[test]
    fn the_least_slope_is_a_lower_bound() {
        let error = |t: f64| libm::pow(t, 8.0) * (1.0 + libm::pow(8.0 * t, 3.0));
        let least = least_slope(&errors(60, error), 1e-15).expect("points");
        assert!((7.5..8.5).contains(&least), "{least}");
        let lower = |t: f64| error(t) + 0.1 * libm::pow(t, 7.0);
        let least = least_slope(&errors(80, lower), 1e-17).expect("points");
        assert!(least < 7.5, "{least}");
        assert!(least_slope(&errors(80, error), 1e3).is_none());
    }
}
