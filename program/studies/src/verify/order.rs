//! Measured orders, and their judgement against declared ones.

use leafwise_core::diagnostics::{fit_order, least_slope};
use leafwise_scene::json::optional;
use serde::Serialize;

use super::judgement::Judgement;

/// A fit that may be off by this much tells no whole number from the next, and is none.
const LARGEST_TOLERANCE: f64 = 1.0;

/// An order as it was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeasuredOrder {
    /// The order fitted with its next term; `None` where too few errors lie between their
    /// pre-asymptotic range and round-off to tell it from the next whole number.
    #[serde(serialize_with = "optional")]
    pub exponent: Option<f64>,
    /// How far it may be from the true one.
    #[serde(serialize_with = "optional")]
    pub tolerance: Option<f64>,
    /// The smallest slope seen near round-off: a lower bound where no fit decides.
    #[serde(serialize_with = "optional")]
    pub at_least: Option<f64>,
}

impl MeasuredOrder {
    /// The order of errors (t, error) whose next term is smaller by t^`gap`.
    pub(crate) fn of(points: &[(f64, f64)], round_off: f64, gap: f64) -> Self {
        let fitted = fit_order(points, round_off, gap);
        let fitted = fitted.filter(|order| order.tolerance < LARGEST_TOLERANCE);
        Self {
            exponent: fitted.map(|order| order.exponent),
            tolerance: fitted.map(|order| order.tolerance),
            at_least: least_slope(points, round_off),
        }
    }

    /// The order n of a defect O(tⁿ⁺¹) of one step, from that of the defect.
    pub(super) fn of_one_step(self) -> Self {
        let less = |order: f64| order - 1.0;
        Self {
            exponent: self.exponent.map(less),
            at_least: self.at_least.map(less),
            ..self
        }
    }

    /// Whether it is at least `declared`. Orders are whole numbers. A fit that holds the declared one has to tell it
    /// from the one below. A fit that holds neither, and a lower bound, have to be nearer to the declared one.
    pub(crate) fn judge(self, declared: usize) -> Judgement {
        let declared = declared as f64;
        if let (Some(exponent), Some(tolerance)) = (self.exponent, self.tolerance) {
            let (lowest, highest) = (exponent - tolerance, exponent + tolerance);
            if highest < declared - 0.5 {
                return Judgement::NotMet;
            }
            let holds = highest >= declared;
            if lowest > declared - if holds { 1.0 } else { 0.5 } {
                return Judgement::Met;
            }
        }
        if self.at_least.is_some_and(|slope| slope >= declared - 0.5) {
            Judgement::Met
        } else {
            Judgement::Undecided
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Judgement, MeasuredOrder};

    /// A fit of an order declared as 4.
    fn judged(exponent: f64, tolerance: f64) -> Judgement {
        let order = MeasuredOrder {
            exponent: Some(exponent),
            tolerance: Some(tolerance),
            at_least: None,
        };
        order.judge(4)
    }

    /// Errors of order 4 times factors between a half and two: no fit of them says anything.
    #[test]
    fn a_fit_without_information_is_none() {
        let factor = [1.0, 0.5, 2.0, 0.6, 1.8, 0.5, 1.9, 1.0];
        let points: Vec<(f64, f64)> = (0..8)
            .map(|k| {
                let t = libm::exp2(-0.25 * f64::from(k));
                (t, factor[k as usize] * t * t * t * t)
            })
            .collect();
        let order = MeasuredOrder::of(&points, 1e-16, 1.0);
        assert_eq!((order.exponent, order.tolerance), (None, None));
        assert!(order.at_least.is_some_and(|slope| slope < 3.5), "{order:?}");
        assert_eq!(order.judge(4), Judgement::Undecided);
    }

    #[test]
    fn the_nearest_whole_number_decides() {
        assert_eq!(judged(4.3, 0.2), Judgement::Met);
        assert_eq!(judged(3.7, 0.6), Judgement::Met, "3 is excluded");
        assert_eq!(judged(3.99, 0.009), Judgement::Met, "no order is 3.99");
        assert_eq!(judged(3.7, 0.8), Judgement::Undecided, "3 and 4 both fit");
        assert_eq!(judged(3.5, 0.1), Judgement::Undecided, "neither is nearer");
        assert_eq!(judged(3.01, 0.009), Judgement::NotMet);
        assert_eq!(judged(3.2, 0.1), Judgement::NotMet);
    }
}
