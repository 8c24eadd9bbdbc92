//! The coefficients of collocation at Gauss nodes.

use leafwise_core::quadrature::{GaussLegendre, legendre};

/// Nodes c_j, weights b_j and integrals of the Lagrange basis ℓ_k at q Gauss–Legendre nodes.
///
/// With W_k the antiderivative of ℓ_k of mean zero on [0, 1]: A_jk = W_k(c_j), and W_k(1) gives
/// the end of the curve. In Legendre polynomials of ξ = 2s − 1,
/// ℓ_k = Σ_{m<q} (2m+1) b_k P_m(ξ_k) P_m and the zero-mean antiderivative of P_m is
/// (P_{m+1} − P_{m−1})/(2(2m+1)), without the constant P_0.
#[derive(Clone, Debug, PartialEq)]
pub struct CollocationRule {
    /// b_j.
    pub weights: Vec<f64>,
    /// A_jk, row-major q × q.
    pub matrix: Vec<f64>,
    /// W_k(1) = −W_{q+1−k}(0).
    pub end: Vec<f64>,
    /// (2m+1) b_k P_m(ξ_k) for m = q−2 and m = q−1, nothing below m = 0: the last Legendre coefficients
    /// of nodal values.
    pub last: [Vec<f64>; 2],
    /// 1 − c_j = ½ − Σ_k A_jk.
    pub remaining: Vec<f64>,
}

impl CollocationRule {
    /// The rule at `q` ≥ 1 nodes.
    pub fn new(q: usize) -> Self {
        let rule = GaussLegendre::new(q);
        let at = |s: f64| legendre(q, 2.0 * s - 1.0);
        let basis: Vec<Vec<f64>> = rule.nodes.iter().map(|c| at(*c)).collect();
        let antiderivative = |values: &[f64], m: usize| {
            let below = if m >= 2 { values[m - 1] } else { 0.0 };
            (values[m + 1] - below) / (2.0 * (2.0 * m as f64 + 1.0))
        };
        let integral = |values: &[f64], k: usize| -> f64 {
            (0..q)
                .map(|m| {
                    (2.0 * m as f64 + 1.0)
                        * rule.weights[k]
                        * basis[k][m]
                        * antiderivative(values, m)
                })
                .sum()
        };
        let matrix: Vec<f64> = basis
            .iter()
            .flat_map(|row| (0..q).map(|k| integral(row, k)))
            .collect();
        let coefficient = |m: usize| {
            let of = |k: usize| (2.0 * m as f64 + 1.0) * rule.weights[k] * basis[k][m];
            (0..q).map(of).collect()
        };
        let last = [
            q.checked_sub(2).map_or(vec![0.0; q], coefficient),
            coefficient(q - 1),
        ];
        let end = at(1.0);
        let rows = matrix.chunks_exact(q);
        Self {
            remaining: rows.map(|row| 0.5 - row.iter().sum::<f64>()).collect(),
            matrix,
            end: (0..q).map(|k| integral(&end, k)).collect(),
            last,
            weights: rule.weights,
        }
    }

    /// q.
    pub fn points(&self) -> usize {
        self.weights.len()
    }
}

#[cfg(test)]
mod tests {
    use super::CollocationRule;

    /// W_k(1) − W_k(0) = b_k with W_k(0) = −W_{q+1−k}(1), and Σ_j b_j A_jk = 0 (mean zero).
    #[test]
    fn antiderivatives_have_mean_zero_and_the_weights_as_increments() {
        for q in 1..=12 {
            let rule = CollocationRule::new(q);
            for k in 0..q {
                let increment = rule.end[k] + rule.end[q - 1 - k];
                assert!((increment - rule.weights[k]).abs() < 16.0 * f64::EPSILON);
                let mean: f64 = (0..q)
                    .map(|j| rule.weights[j] * rule.matrix[j * q + k])
                    .sum();
                assert!(mean.abs() < 16.0 * f64::EPSILON, "q = {q}: {mean:e}");
            }
        }
    }
}
