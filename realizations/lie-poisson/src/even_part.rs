//! (Z/2) coth(Z/2) = 1 + f(W), W = Z²/4, by partial fractions of a continued fraction.
//!
//! With w = z², z coth z − 1 is Lambert's continued fraction f(w) = w/(3 + w/(5 + w/(7 + …))), a
//! Stieltjes function. Cut after 2n levels it is Σ_j r_j w/(1 + s_j w) with n weights r_j > 0 and n
//! shifts s_j > 0, its poles −1/s_j near −(jπ)². On matrices every term is one linear solve with
//! 1 + s_j W: nothing overflows and, for real eigenvalues of Z, nothing cancels, whatever their
//! size.

use nalgebra::DMatrix;

/// One term r w/(1 + s w).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraction {
    /// r.
    pub weight: f64,
    /// s.
    pub shift: f64,
}

/// The largest |w| served: beyond, e^Z is of no use in doubles.
pub const LARGEST: f64 = 4096.0;

/// How many fractions give f(w) to round-off for |w| ≤ `bound` ≤ [`LARGEST`]: after K levels the
/// remainder is w^K/(3·5²·7²⋯(2K+1)²(2K+3)) of f to leading order.
pub fn needed(bound: f64) -> usize {
    let mut remainder = 1.0;
    let mut n = 0;
    while remainder > f64::EPSILON / 16.0 {
        for k in [2 * n + 1, 2 * n + 2] {
            remainder *= bound / ((2 * k + 1) * (2 * k + 3)) as f64;
        }
        n += 1;
    }
    n.max(1)
}

/// The n fractions.
///
/// With t = 1/w, f = 1/(3t + 1/(5 + 1/(7t + 1/(9 + …)))) is the first entry of (tM + L)⁻¹. Here
/// M = diag(3, 7, 11, …) are masses on a string of lengths 5, 9, 13, … with stiffness L. The s_j
/// are the eigenvalues of M^{−½} L M^{−½} and the r_j its spectral weights (T. J. Stieltjes 1894;
/// computed as by Golub and Welsch 1969).
pub fn fractions(n: usize) -> Vec<Fraction> {
    let mass = |i: usize| (4 * i + 3) as f64;
    let stiffness = |i: usize| 1.0 / (4 * i + 5) as f64;
    let string = DMatrix::from_fn(n, n, |i, j| {
        let entry = match i.abs_diff(j) {
            0 if i == 0 => stiffness(0),
            0 => stiffness(i - 1) + stiffness(i),
            1 => -stiffness(i.min(j)),
            _ => 0.0,
        };
        entry / libm::sqrt(mass(i) * mass(j))
    });
    let spectrum = string.symmetric_eigen();
    (0..n)
        .map(|j| {
            let first = spectrum.eigenvectors[(0, j)];
            Fraction {
                weight: first * first / mass(0),
                shift: spectrum.eigenvalues[j],
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{LARGEST, fractions, needed};

    fn value(w: f64) -> f64 {
        let sum = fractions(needed(w.abs())).into_iter();
        sum.map(|f| f.weight * w / (1.0 + f.shift * w)).sum()
    }

    /// For real z the value against z coth z; for z = iθ against θ cot θ, up to 0.95 of the wall.
    #[test]
    fn the_fractions_give_coth_and_cot() {
        for i in 1..=200 {
            let z = libm::sqrt(LARGEST) * f64::from(i) / 200.0;
            let expected = z / libm::tanh(z) - 1.0;
            let error = (value(z * z) - expected).abs() / (1.0 + expected);
            // The spectral problem of size n is solved to n roundings.
            let bound = (16 + needed(z * z)) as f64 * f64::EPSILON;
            assert!(error <= bound, "z = {z}: {error:e}");
            let theta = 0.95 * std::f64::consts::PI * f64::from(i) / 200.0;
            let expected = theta / libm::tan(theta) - 1.0;
            // θ cot θ has condition θ²/sin²θ and loses what the 1 cancels.
            let sine = libm::sin(theta);
            let condition = theta * theta / (sine * sine);
            let error = (value(-theta * theta) - expected).abs();
            assert!(
                error <= 32.0 * f64::EPSILON * condition,
                "θ = {theta}: {error:e}"
            );
        }
    }

    /// Near 0 the series f = w/3 − w²/45 + 2w³/945 − …, relatively.
    #[test]
    fn small_arguments_keep_their_relative_accuracy() {
        for i in 1..=60 {
            let w = libm::exp2(-10.0 - f64::from(i));
            for w in [w, -w] {
                let series = w / 3.0 * (1.0 - w / 15.0 * (1.0 - 2.0 * w / 21.0 * (1.0 - w / 10.0)));
                let error = (value(w) / series - 1.0).abs();
                assert!(error <= 16.0 * f64::EPSILON, "w = {w}: {error:e}");
            }
        }
    }
}
