//! Coefficients of Runge–Kutta methods.

use std::sync::OnceLock;

use crate::quadrature::{GaussLegendre, legendre};

/// The coefficients c_i, b_i, a_ij of an s-stage Runge–Kutta method.
#[derive(Clone, Debug, PartialEq)]
pub struct Tableau {
    /// c_1, …, c_s.
    pub nodes: Vec<f64>,
    /// b_1, …, b_s.
    pub weights: Vec<f64>,
    /// a_ij, row-major s × s.
    pub matrix: Vec<f64>,
}

/// Two tableaux with the same weights: the first for the leading coordinates, the second for the
/// others.
///
/// For a Hamiltonian system in coordinates (x, p) the method is symplectic when
/// b_i â_ij + b_j a_ji = b_i b_j (Hairer, Lubich, Wanner, *Geometric Numerical Integration*,
/// Theorem VI.4.6).
#[derive(Clone, Debug, PartialEq)]
pub struct PartitionedTableau {
    /// a_ij, for the coordinates before `split`.
    pub first: Tableau,
    /// â_ij, for the others.
    pub second: Tableau,
    /// How many coordinates the first tableau advances.
    pub split: usize,
}

impl Tableau {
    /// The most stages offered of a Gauss method: order 32, where round-off hides what a stage adds.
    pub const MOST_STAGES: usize = 16;

    /// The Gauss method with s ≥ 1 stages, of order 2s: collocation at the nodes of Gauss and
    /// Legendre (Hairer, Lubich, Wanner, section II.1.3).
    ///
    /// With P̃ the Legendre polynomials on [0, 1], ℓ_j = b_j Σ_{k<s} (2k+1) P̃_k(c_j) P̃_k and
    /// ∫₀ᶜ P̃_k = (P̃_{k+1}(c) − P̃_{k−1}(c)) / (2(2k+1)). Therefore a_ij = ∫₀^{c_i} ℓ_j is
    /// b_j (c_i + ½ Σ_{1≤k<s} P̃_k(c_j) (P̃_{k+1}(c_i) − P̃_{k−1}(c_i))). Every summand is of size 1, whatever s.
    ///
    /// # Panics
    /// When `stages` is 0.
    pub fn gauss(stages: usize) -> Self {
        let rule = GaussLegendre::new(stages);
        Self {
            matrix: integrals(&rule, 0.0),
            nodes: rule.nodes,
            weights: rule.weights,
        }
    }

    /// e_ij = ∫₁^{1+c_i} ℓ_j, row-major s × s, for the Lagrange polynomials ℓ_j of the Gauss nodes c_j. The stages of
    /// the step that follows are z + τ Σ_j e_ij F(Z_j). They continue the collocation polynomial of this step.
    ///
    /// # Panics
    /// When `stages` is 0 or more than [`Tableau::MOST_STAGES`].
    pub(super) fn gauss_onward(stages: usize) -> &'static [f64] {
        static KNOWN: [OnceLock<Vec<f64>>; Tableau::MOST_STAGES] =
            [const { OnceLock::new() }; Tableau::MOST_STAGES];
        KNOWN[stages - 1].get_or_init(|| {
            let rule = GaussLegendre::new(stages);
            let mut matrix = integrals(&rule, 1.0);
            for row in matrix.chunks_exact_mut(stages) {
                for (entry, weight) in row.iter_mut().zip(&rule.weights) {
                    *entry -= weight;
                }
            }
            matrix
        })
    }

    /// s.
    pub fn stages(&self) -> usize {
        self.nodes.len()
    }
}

/// ∫₀^{c_i + `beyond`} ℓ_j, as [`Tableau::gauss`] says.
fn integrals(rule: &GaussLegendre, beyond: f64) -> Vec<f64> {
    let stages = rule.points();
    let at = |c: f64| legendre(stages, 2.0 * c - 1.0);
    let polynomials: Vec<Vec<f64>> = rule.nodes.iter().map(|c| at(*c)).collect();
    let mut matrix = Vec::with_capacity(stages * stages);
    for node in &rule.nodes {
        let end = node + beyond;
        let here = at(end);
        for (weight, there) in rule.weights.iter().zip(&polynomials) {
            let rest: f64 = (1..stages)
                .map(|k| there[k] * (here[k + 1] - here[k - 1]))
                .sum();
            matrix.push(weight * (end + 0.5 * rest));
        }
    }
    matrix
}

impl From<Tableau> for PartitionedTableau {
    /// The same tableau for every coordinate.
    fn from(tableau: Tableau) -> Self {
        Self {
            first: tableau.clone(),
            second: tableau,
            split: 0,
        }
    }
}

impl PartitionedTableau {
    /// s.
    pub fn stages(&self) -> usize {
        self.first.stages()
    }

    /// b_1, …, b_s.
    pub fn weights(&self) -> &[f64] {
        &self.first.weights
    }

    /// The row (a_ij)_j of stage i for a coordinate.
    pub fn row(&self, stage: usize, coordinate: usize) -> &[f64] {
        let tableau = if coordinate < self.split {
            &self.first
        } else {
            &self.second
        };
        let s = self.stages();
        &tableau.matrix[stage * s..][..s]
    }
}

#[cfg(test)]
mod tests {
    use super::Tableau;

    /// Sums of at most sixteen products of size at most 1, coefficients within two roundings.
    const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

    #[test]
    fn gauss_satisfies_its_simplifying_assumptions() {
        for s in 1..=Tableau::MOST_STAGES {
            let gauss = Tableau::gauss(s);
            let moment = |row: &[f64], k: usize| -> f64 {
                let terms = row.iter().zip(&gauss.nodes);
                terms.map(|(a, c)| a * libm::pow(*c, k as f64 - 1.0)).sum()
            };
            // B(2s): Σ b_i c_i^{k−1} = 1/k.
            for k in 1..=2 * s {
                let error = (moment(&gauss.weights, k) - 1.0 / k as f64).abs();
                assert!(error <= ROUND_OFF, "B({k}) for s = {s}: {error:e}");
            }
            // C(s): Σ_j a_ij c_j^{k−1} = c_i^k / k.
            for (row, c) in gauss.matrix.chunks(s).zip(&gauss.nodes) {
                for k in 1..=s {
                    let error = (moment(row, k) - libm::pow(*c, k as f64) / k as f64).abs();
                    assert!(error <= ROUND_OFF, "C({k}) for s = {s}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn gauss_is_symplectic_and_symmetric() {
        for s in 1..=Tableau::MOST_STAGES {
            let Tableau {
                weights: b,
                matrix: a,
                ..
            } = Tableau::gauss(s);
            for i in 0..s {
                for j in 0..s {
                    let symplectic = b[i] * a[i * s + j] + b[j] * a[j * s + i] - b[i] * b[j];
                    let mirrored = a[(s - 1 - i) * s + (s - 1 - j)];
                    let symmetric = a[i * s + j] + mirrored - b[j];
                    assert!(symplectic.abs() <= ROUND_OFF, "s = {s}: {symplectic:e}");
                    assert!(symmetric.abs() <= ROUND_OFF, "s = {s}: {symmetric:e}");
                }
            }
        }
    }

    /// Hairer, Lubich, Wanner, table II.1.1.
    #[test]
    fn the_method_of_two_stages_is_hammer_and_hollingsworths() {
        let gauss = Tableau::gauss(2);
        let r = libm::sqrt(3.0) / 6.0;
        let expected = [0.25, 0.25 - r, 0.25 + r, 0.25];
        for (found, expected) in gauss.matrix.iter().zip(expected) {
            assert!((found - expected).abs() <= f64::EPSILON);
        }
    }
}
