//! A composition scheme.

use leafwise_core::Pieces;
use leafwise_core::part::PartInfo;

/// The numbers of a scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coefficients {
    /// Φ_{γ_s h} ∘ … ∘ Φ_{γ_1 h} over any self-adjoint map, γ_i = γ_{s+1−i} and Σγ_i = 1:
    /// γ_1, …, γ_{(s+1)/2}, the centre last.
    Stages(&'static [f64]),
    /// χ*_{α_{2s} h} ∘ χ_{α_{2s−1} h} ∘ … ∘ χ*_{α_2 h} ∘ χ_{α_1 h} over a map of order 1 and its adjoint. The numbers
    /// are α_1, …, α_s, where α_i = α_{2s+1−i} and Σα_i = 1.
    Factors(&'static [f64]),
}

/// A symmetric composition of an even order P.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Name, claims, domain and literature of the scheme's part.
    pub info: &'static PartInfo,
    /// P, over a base of order 2.
    pub order: usize,
    /// Its first half.
    pub half: Coefficients,
    /// The pieces for which its order is proved.
    pub pieces: Pieces,
}

impl Scheme {
    /// s: a factor χ or χ* is half a stage.
    pub fn stages(&self) -> usize {
        match self.half {
            Coefficients::Stages(half) => 2 * half.len() - 1,
            Coefficients::Factors(half) => half.len(),
        }
    }

    /// Whether it needs χ and χ*.
    pub fn takes_factors(&self) -> bool {
        matches!(self.half, Coefficients::Factors(_))
    }

    /// γ_1, …, γ_s, or α_1, …, α_{2s}.
    pub fn coefficients(&self) -> Vec<f64> {
        let (half, centre) = match self.half {
            Coefficients::Stages(half) => (half, 1),
            Coefficients::Factors(half) => (half, 0),
        };
        let mirrored = half.iter().rev().skip(centre);
        half.iter().chain(mirrored).copied().collect()
    }

    /// α_1, …, α_{2s}: of stages α_{2i−1} = α_{2i} = γ_i/2, since Φ_h = χ*_{h/2} ∘ χ_{h/2}.
    pub fn parts(&self) -> Vec<f64> {
        let coefficients = self.coefficients();
        match self.half {
            Coefficients::Stages(_) => {
                let halves = coefficients.iter().map(|gamma| 0.5 * gamma);
                halves.flat_map(|half| [half, half]).collect()
            }
            Coefficients::Factors(_) => coefficients,
        }
    }

    /// A lower bound of the order over a base of order `base`.
    ///
    /// A self-adjoint base is exp(hY_1 + h^{p+1}Y_{p+1} + …) with odd grades alone. The order conditions of grade up
    /// to P hold whatever the Y_k are, so the order is at least P. Where p is larger, the base is exp(hY_1) up to h^p,
    /// and Σγ_i = 1 keeps that. The bound is max(P, p). Order conditions over χ and χ* hold whatever χ is, and say
    /// nothing of what p > P would bring. A base of order 0 is not consistent, and no composition of it is.
    pub fn order_over(&self, base: usize) -> usize {
        match (base, self.half) {
            (0, _) => 0,
            (_, Coefficients::Stages(_)) => self.order.max(base),
            (_, Coefficients::Factors(_)) => self.order,
        }
    }
}
