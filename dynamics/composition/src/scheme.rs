//! A symmetric composition scheme.

use leafwise_core::part::PartInfo;

/// γ_1, …, γ_s with γ_i = γ_{s+1−i} and Σγ_i = 1, of an even order P over any self-adjoint map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// What its part declares.
    pub info: &'static PartInfo,
    /// P, over a base of order 2.
    pub order: usize,
    /// γ_1, …, γ_{(s+1)/2}, the centre last.
    pub half: &'static [f64],
}

impl Scheme {
    /// s, odd.
    pub fn stages(&self) -> usize {
        2 * self.half.len() - 1
    }

    /// γ_1, …, γ_s.
    pub fn coefficients(&self) -> Vec<f64> {
        let mirrored = self.half.iter().rev().skip(1);
        self.half.iter().chain(mirrored).copied().collect()
    }

    /// A lower bound of the order over a self-adjoint base of order `base`.
    ///
    /// Such a base is exp(hY_1 + h^{p+1}Y_{p+1} + …) with odd grades alone. The order conditions of
    /// grade up to P hold whatever the Y_k are, so the order is at least P; where p is larger, the
    /// base is exp(hY_1) up to h^p, and Σγ_i = 1 keeps that: max(P, p). A base of order 0 is not
    /// consistent, and no composition of it is.
    pub fn order_over(&self, base: usize) -> usize {
        if base == 0 { 0 } else { self.order.max(base) }
    }
}
