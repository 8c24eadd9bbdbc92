//! The implicit midpoint rule.

use leafwise_core::runge_kutta::{PartitionedTableau, Tableau};

/// z⁺ = z + h F((z + z⁺)/2): the implicit midpoint rule, of order 2. Its one stage has c = ½,
/// b = 1, a = ½ (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, section II.1).
pub fn implicit_midpoint() -> PartitionedTableau {
    Tableau {
        nodes: vec![0.5],
        weights: vec![1.0],
        matrix: vec![0.5],
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::implicit_midpoint;
    use crate::gauss::gauss;

    #[test]
    fn it_is_the_gauss_method_of_one_stage() {
        assert_eq!(implicit_midpoint(), gauss(1));
    }
}
