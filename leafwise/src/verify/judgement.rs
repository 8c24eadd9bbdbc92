//! Declarations against measurements.

use leafwise_core::diagnostics::Defect;
use leafwise_core::{MapProperties, Structure};
use serde::Serialize;

use super::convergence::Convergence;
use super::defects::Defects;

/// Whether a declaration is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// The measurement agrees.
    Met,
    /// It does not.
    NotMet,
    /// The measurement does not tell the declared order from the one below.
    Undecided,
    /// Nothing was declared, or the map offers nothing to measure it by.
    Open,
}

/// The order in t. No order is better than errors that are round-off at every step.
pub(super) fn judge_order(declared: MapProperties, convergence: &Convergence) -> Judgement {
    if convergence.is_round_off() {
        return Judgement::Met;
    }
    convergence.order.judge(declared.order)
}

/// Round-off at every step is an exact structure, and better than any order.
pub(super) fn judge_structure(declared: MapProperties, defects: &Defects) -> Judgement {
    match (declared.structure, defects.is_round_off()) {
        (_, None) | (Structure::None, _) => Judgement::Open,
        (_, Some(true)) => Judgement::Met,
        (Structure::Exact, Some(false)) => Judgement::NotMet,
        (Structure::Order(n), Some(false)) => defects.order.judge(n),
    }
}

pub(super) fn judge_symmetry(declared: MapProperties, defect: f64) -> Judgement {
    match declared.self_adjoint {
        Some(true) if defect <= Defect::ROUND_OFF => Judgement::Met,
        Some(true) => Judgement::NotMet,
        Some(false) | None => Judgement::Open,
    }
}
