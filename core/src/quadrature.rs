//! Gauss–Legendre quadrature on [0, 1] and the polynomials behind it.

/// Nodes c_j and weights b_j of the Gauss–Legendre rule with q points on [0, 1], exact for
/// polynomials of degree 2q − 1.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussLegendre {
    /// c_1 < … < c_q.
    pub nodes: Vec<f64>,
    /// b_j, positive, of sum 1.
    pub weights: Vec<f64>,
}

impl GaussLegendre {
    /// The rule with `q` ≥ 1 points, nodes to a unit in the last place: Newton's method on P_q from
    /// Tricomi's first approximation.
    ///
    /// # Panics
    /// When `q` is 0.
    pub fn new(q: usize) -> Self {
        assert!(q > 0, "a quadrature rule has at least one node");
        let mut nodes = vec![0.5; q];
        let mut weights = vec![0.0; q];
        for j in 0..q.div_ceil(2) {
            let angle = std::f64::consts::PI * (j as f64 + 0.75) / (q as f64 + 0.5);
            let mut xi = libm::cos(angle);
            for _ in 0..100 {
                let (value, slope) = legendre_with_slope(q, xi);
                let change = value / slope;
                xi -= change;
                if change.abs() <= f64::EPSILON * xi.abs() {
                    break;
                }
            }
            if 2 * j + 1 == q {
                xi = 0.0;
            }
            let (_, slope) = legendre_with_slope(q, xi);
            // b = 1/((1 − ξ²) P_q′(ξ)²) on [0, 1].
            let weight = 1.0 / ((1.0 - xi * xi) * slope * slope);
            nodes[q - 1 - j] = 0.5 + 0.5 * xi;
            nodes[j] = 0.5 - 0.5 * xi;
            weights[j] = weight;
            weights[q - 1 - j] = weight;
        }
        Self { nodes, weights }
    }

    /// The number of nodes.
    pub fn points(&self) -> usize {
        self.nodes.len()
    }
}

fn legendre_with_slope(n: usize, xi: f64) -> (f64, f64) {
    let values = legendre(n, xi);
    let before = if n == 0 { 0.0 } else { values[n - 1] };
    (
        values[n],
        n as f64 * (before - xi * values[n]) / (1.0 - xi * xi),
    )
}

/// P_0(ξ), …, P_n(ξ), the Legendre polynomials on [−1, 1].
pub fn legendre(n: usize, xi: f64) -> Vec<f64> {
    let mut values = vec![1.0; n + 1];
    if n > 0 {
        values[1] = xi;
    }
    for k in 1..n {
        let (k_real, next) = (k as f64, k as f64 + 1.0);
        values[k + 1] = ((2.0 * k_real + 1.0) * xi * values[k] - k_real * values[k - 1]) / next;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::GaussLegendre;

    /// Σ b_j c_jᵏ = 1/(k+1) for k < 2q: q terms of size at most 1.
    #[test]
    fn moments_up_to_twice_the_points_are_exact() {
        for q in 1..=20 {
            let rule = GaussLegendre::new(q);
            for k in 0..2 * q {
                let moment: f64 = rule
                    .nodes
                    .iter()
                    .zip(&rule.weights)
                    .map(|(c, b)| b * libm::pow(*c, k as f64))
                    .sum();
                let error = (moment - 1.0 / (k as f64 + 1.0)).abs();
                assert!(error <= 8.0 * f64::EPSILON, "q = {q}, k = {k}: {error:e}");
            }
        }
    }
}
