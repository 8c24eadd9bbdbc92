//! Gauss methods.

use leafwise_core::runge_kutta::{PartitionedTableau, Tableau};

/// Collocation at s Gauss nodes, symplectic, symmetric, of order 2s (Hairer, Lubich, Wanner,
/// *Geometric Numerical Integration*, sections II.1.3 and VI.4).
pub fn gauss(stages: usize) -> PartitionedTableau {
    Tableau::gauss(stages).into()
}
