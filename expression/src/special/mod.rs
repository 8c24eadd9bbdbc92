//! Special functions with all their derivatives: ln|Γ|, the Bessel functions J₀ and J₁, complete elliptic integrals.
//!
//! Each is a function of one argument whose k-th derivative is evaluated as it stands. So no formula of a derivative
//! divides by an argument that may be 0.

mod bessel;
mod elliptic;
mod gamma;
mod scaled;
#[cfg(test)]
mod tests;

use crate::analytic::AnalyticFunction;

/// A function whose derivatives are no formulas of elementary functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Special {
    /// ln |Γ(x)|.
    LnGamma,
    /// The Bessel function J₀.
    J0,
    /// The Bessel function J₁.
    J1,
    /// K(m) = ∫₀^{π/2} dθ/√(1 − m sin²θ).
    EllipticK,
    /// E(m) = ∫₀^{π/2} √(1 − m sin²θ) dθ.
    EllipticE,
}

impl Special {
    /// The name that formulas use.
    pub fn name(self) -> &'static str {
        match self {
            Self::LnGamma => "lgamma",
            Self::J0 => "j0",
            Self::J1 => "j1",
            Self::EllipticK => "ellipk",
            Self::EllipticE => "ellipe",
        }
    }

    /// f⁽ᵏ⁾(x): the same bits on every machine; NaN outside the domain; at a pole infinite, or NaN where its sides differ.
    pub fn derivative(self, order: u32, x: f64) -> f64 {
        match self {
            Self::LnGamma => gamma::ln_gamma(order, x),
            Self::J0 => bessel::derivative(0, order, x),
            Self::J1 => bessel::derivative(1, order, x),
            Self::EllipticK => elliptic::first_kind(order, x),
            Self::EllipticE => elliptic::second_kind(order, x),
        }
    }

    /// The function as straight-line code calls it.
    pub(crate) fn analytic(self) -> AnalyticFunction {
        match self {
            Self::LnGamma => AnalyticFunction::new("lgamma", gamma::ln_gamma),
            Self::J0 => AnalyticFunction::new("j0", |order, x| bessel::derivative(0, order, x)),
            Self::J1 => AnalyticFunction::new("j1", |order, x| bessel::derivative(1, order, x)),
            Self::EllipticK => AnalyticFunction::new("ellipk", elliptic::first_kind),
            Self::EllipticE => AnalyticFunction::new("ellipe", elliptic::second_kind),
        }
    }
}
