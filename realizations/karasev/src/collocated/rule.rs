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
    /// P_m(ξ_k) and (2m+1) b_k P_m(ξ_k) at the nodes up to the middle: a row for each m, q ⌈q/2⌉.
    basis: Vec<f64>,
    dual: Vec<f64>,
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
        let places = || (0..q).flat_map(|m| (0..q.div_ceil(2)).map(move |k| (m, k)));
        let dual = |(m, k): (usize, usize)| (2.0 * m as f64 + 1.0) * rule.weights[k] * basis[k][m];
        let end = at(1.0);
        Self {
            matrix,
            end: (0..q).map(|k| integral(&end, k)).collect(),
            basis: places().map(|(m, k)| basis[k][m]).collect(),
            dual: places().map(dual).collect(),
            weights: rule.weights,
        }
    }

    /// q.
    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// Writes the Legendre coefficients of nodal `values` with d components each into `coefficients`. P_m is even or
    /// odd about the middle, so that sums and differences of mirrored nodes will do. These overwrite the values.
    pub fn to_coefficients(&self, values: &mut [f64], coefficients: &mut [f64], d: usize) {
        let q = self.points();
        for j in 0..q / 2 {
            let (before, behind) = values.split_at_mut((q - 1 - j) * d);
            for (a, b) in before[j * d..][..d].iter_mut().zip(behind) {
                (*a, *b) = (*a + *b, *a - *b);
            }
        }
        let half = q.div_ceil(2);
        let rows = coefficients
            .chunks_exact_mut(d)
            .zip(self.dual.chunks_exact(half));
        for (m, (sums, row)) in rows.enumerate() {
            sums.fill(0.0);
            for (j, factor) in row.iter().enumerate() {
                let is_middle = 2 * j + 1 == q;
                if m % 2 == 1 && is_middle {
                    continue;
                }
                let at = if m % 2 == 0 { j } else { q - 1 - j };
                for (sum, value) in sums.iter_mut().zip(&values[at * d..]) {
                    *sum += factor * value;
                }
            }
        }
    }

    /// The nodal values of Legendre coefficients with d components each.
    pub fn to_values(&self, coefficients: &[f64], values: &mut [f64], d: usize) {
        let q = self.points();
        let half = q.div_ceil(2);
        values.fill(0.0);
        let rows = coefficients
            .chunks_exact(d)
            .zip(self.basis.chunks_exact(half));
        for (m, (coefficients, row)) in rows.enumerate() {
            for (j, factor) in row.iter().enumerate() {
                let is_middle = 2 * j + 1 == q;
                if m % 2 == 1 && is_middle {
                    continue;
                }
                let at = if m % 2 == 0 { j } else { q - 1 - j };
                for (sum, a) in values[at * d..][..d].iter_mut().zip(coefficients) {
                    *sum += factor * a;
                }
            }
        }
        for j in 0..q / 2 {
            let (before, behind) = values.split_at_mut((q - 1 - j) * d);
            for (a, b) in before[j * d..][..d].iter_mut().zip(behind) {
                (*a, *b) = (*a + *b, *a - *b);
            }
        }
    }

    /// Operations of either of them.
    pub fn operations(&self, d: usize) -> u64 {
        let q = self.points();
        (q * (q + 1) * d) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::{CollocationRule, GaussLegendre};

    /// s³ − s of any size, from four nodes on; what its coefficients are is told by Legendre's polynomials.
    #[test]
    fn nodal_values_and_legendre_coefficients_are_each_others() {
        for q in 4..=12 {
            let rule = CollocationRule::new(q);
            let nodes = GaussLegendre::new(q).nodes;
            let at = |xi: f64| [xi * xi * xi - xi, 1.0 + 3.0 * xi * xi];
            let exact: Vec<f64> = nodes.iter().flat_map(|c| at(2.0 * c - 1.0)).collect();
            let mut coefficients = vec![0.0; 2 * q];
            rule.to_coefficients(&mut exact.clone(), &mut coefficients, 2);
            let mut expected = vec![0.0; 2 * q];
            expected[..8].copy_from_slice(&[0.0, 2.0, -0.4, 0.0, 0.0, 2.0, 0.4, 0.0]);
            let mut values = vec![0.0; 2 * q];
            rule.to_values(&coefficients, &mut values, 2);
            for (found, exact) in [(coefficients, expected), (values, exact)] {
                let errors = found.iter().zip(&exact).map(|(a, b)| (a - b).abs());
                let error = errors.fold(0.0, f64::max);
                assert!(error <= 256.0 * f64::EPSILON, "q = {q}: {error:e}");
            }
        }
    }

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
