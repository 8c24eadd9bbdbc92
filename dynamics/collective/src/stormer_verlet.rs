//! The Störmer–Verlet method.

use leafwise_core::runge_kutta::{PartitionedTableau, Tableau};

/// Störmer–Verlet, of order 2, as the partitioned pair Lobatto IIIA–IIIB of two stages (Hairer,
/// Lubich, Wanner, *Geometric Numerical Integration*, table II.2.1).
///
/// For d positions:
///
/// p₁ᵢ₂ = p + (h/2) K_x(x, p₁ᵢ₂), x⁺ = x − (h/2)(K_p(x, p₁ᵢ₂) + K_p(x⁺, p₁ᵢ₂)),
/// p⁺ = p₁ᵢ₂ + (h/2) K_x(x⁺, p₁ᵢ₂).
///
/// Collective Hamiltonians are not separable, so both half steps are implicit.
pub fn stormer_verlet(dimension: usize) -> PartitionedTableau {
    let tableau = |matrix: [f64; 4]| Tableau {
        nodes: vec![0.0, 1.0],
        weights: vec![0.5, 0.5],
        matrix: matrix.to_vec(),
    };
    PartitionedTableau {
        first: tableau([0.0, 0.0, 0.5, 0.5]),
        second: tableau([0.5, 0.0, 0.5, 0.0]),
        split: dimension,
    }
}

#[cfg(test)]
mod tests {
    use super::stormer_verlet;

    /// b_i â_ij + b_j a_ji = b_i b_j, in numbers without rounding.
    #[test]
    fn it_is_symplectic() {
        let pair = stormer_verlet(1);
        let b = pair.weights();
        for i in 0..2 {
            for j in 0..2 {
                let sum = b[i] * pair.row(i, 1)[j] + b[j] * pair.row(j, 0)[i];
                assert_eq!(sum, b[i] * b[j]);
            }
        }
    }
}
