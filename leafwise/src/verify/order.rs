//! What is known of an order.

use leafwise_core::diagnostics::{fit_order, least_slope};
use serde::Serialize;

use super::judgement::Judgement;

/// An order as it was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeasuredOrder {
    /// The order fitted with its next term; `None` where too few errors lie between their
    /// pre-asymptotic range and round-off.
    pub exponent: Option<f64>,
    /// How far it may be from the true one.
    pub tolerance: Option<f64>,
    /// The smallest slope seen near round-off: a lower bound where no fit decides.
    pub at_least: Option<f64>,
}

impl MeasuredOrder {
    /// The order of errors (t, error) whose next term is smaller by t^`gap`.
    pub(crate) fn of(points: &[(f64, f64)], round_off: f64, gap: f64) -> Self {
        let fitted = fit_order(points, round_off, gap);
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

    /// Whether it is at least `declared`. Orders are whole numbers: the fit has to tell the declared
    /// one from the one below; a lower bound has to be nearer to it.
    pub(crate) fn judge(self, declared: usize) -> Judgement {
        let declared = declared as f64;
        if let (Some(exponent), Some(tolerance)) = (self.exponent, self.tolerance) {
            if exponent + tolerance < declared {
                return Judgement::NotMet;
            }
            if exponent - tolerance > declared - 1.0 {
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
