//! Orders as they are reported.

use leafwise_core::diagnostics::{FittedOrder, fit_order};
use leafwise_report::{PanelSeries, Stroke};

use super::error::ReproduceError;
use super::figure::Finding;
use super::paper::Claim;

/// Errors (parameter, error), and the size of round-off in them.
#[derive(Clone, Debug)]
pub struct ErrorCurve {
    /// By any order of parameters.
    pub points: Vec<(f64, f64)>,
    /// Size of round-off in an error, in the unit of the error.
    pub round_off: f64,
}

/// `count` numbers an octave from `largest` downwards, over `octaves`.
pub(super) fn geometric(largest: f64, octaves: u32, count: u32) -> Vec<f64> {
    (0..=octaves * count)
        .map(|k| largest * libm::exp2(-f64::from(k) / f64::from(count)))
        .collect()
}

impl ErrorCurve {
    /// The exponent of the leading term; the next one is smaller by the power `gap`.
    pub(super) fn order(&self, figure: usize, gap: f64) -> Result<FittedOrder, ReproduceError> {
        fit_order(&self.points, self.round_off, gap).ok_or(ReproduceError::NoOrder { figure })
    }

    /// The power law of exponent `order` through the finest point above ten times round-off.
    pub(super) fn guide(&self, order: f64) -> PanelSeries {
        let above = || self.points.iter().filter(|p| p.1 > 10.0 * self.round_off);
        let finest = above().min_by(|a, b| a.0.total_cmp(&b.0));
        let coarsest = above().max_by(|a, b| a.0.total_cmp(&b.0));
        let points = finest.zip(coarsest).map(|(fine, coarse)| {
            let end = fine.1 * libm::pow(coarse.0 / fine.0, order);
            vec![*fine, (coarse.0, end)]
        });
        PanelSeries {
            name: format!("slope {order}"),
            points: points.unwrap_or_default(),
            stroke: Stroke::Guide,
        }
    }
}

/// A fitted order beside the printed one and that of theory. Printed slopes are read as exact to
/// half a unit of their last digit, which is `rounding`.
pub(super) fn finding(
    claim: &'static Claim,
    fitted: FittedOrder,
    theory: f64,
    rounding: f64,
    explanation: String,
) -> Finding {
    let off = |value: f64| (fitted.exponent - value).abs();
    Finding {
        claim,
        measured: format!(
            "{:.2} ± {:.2}",
            fitted.exponent,
            fitted.tolerance.max(0.005)
        ),
        value: Some(fitted.exponent),
        tolerance: Some(fitted.tolerance),
        explanation,
        agrees: Some(
            claim
                .value
                .is_none_or(|printed| off(printed) <= fitted.tolerance + rounding),
        ),
        holds: fitted.tolerance < 0.5 && off(theory) <= fitted.tolerance,
    }
}
