//! The entire functions that close a Lie series.
//!
//! Where D²f = φ·Df with Dφ = 0 the flow is f + t·Df·φ₁(tφ). Where D³f = −λ·Df with Dλ = 0 it is
//! f + t·Df·c₁(t²λ) + t²·D²f·c₂(t²λ). The functions are
//!
//! φ_k(z) = Σ_j zʲ/(j + k)!, φ₁(z) = (eᶻ − 1)/z,
//! c_k(s) = Σ_j (−s)ʲ/(2j + k)!, c₁(s) = sin(√s)/√s, c₂(s) = (1 − cos √s)/s.
//!
//! The latter are Stumpff's (K. Stumpff, *Himmelsmechanik I* (1959), section 41). Neither kind
//! needs a division by φ or √λ, or their sign. Rotations, hyperbolic motions and the limits between
//! them are one formula. Where the divisions can be carried out exactly,
//! [`Motion`](crate::flow::Motion) has forms that round better.

use leafwise_expression::AnalyticFunction;

/// φ₁ with φ_k′ = φ_k − k φ_{k+1}.
pub const PHI_1: AnalyticFunction =
    AnalyticFunction::new("splitting-phi1", |order, z| phi_derivative(1, order, z));

/// c₁ with c_k′ = (k c_{k+2} − c_{k+1})/2.
pub const STUMPFF_1: AnalyticFunction = AnalyticFunction::new("splitting-stumpff1", |order, s| {
    stumpff_derivative(1, order, s)
});

/// c₂.
pub const STUMPFF_2: AnalyticFunction = AnalyticFunction::new("splitting-stumpff2", |order, s| {
    stumpff_derivative(2, order, s)
});

/// Where the series of the higher functions take over from the recursions: the recursions cancel
/// below, the terms of the series grow above.
const SERIES: f64 = 2.0;

fn factorial(k: u32) -> f64 {
    (1..=k).map(f64::from).product()
}

/// Σ_j rʲ/(stride·j + k)!, to the last term that counts.
fn series(ratio: f64, k: u32, stride: u32) -> f64 {
    let mut term = 1.0 / factorial(k);
    let mut sum = term;
    let mut last = k;
    while term.abs() > f64::EPSILON / 16.0 * sum.abs() {
        for _ in 0..stride {
            last += 1;
            term /= f64::from(last);
        }
        term *= ratio;
        sum += term;
    }
    sum
}

fn phi(k: u32, z: f64) -> f64 {
    match k {
        0 => libm::exp(z),
        1 if z == 0.0 => 1.0,
        1 => libm::expm1(z) / z,
        _ if z.abs() <= SERIES => series(z, k, 1),
        _ => (phi(k - 1, z) - 1.0 / factorial(k - 1)) / z,
    }
}

fn phi_derivative(k: u32, order: u32, z: f64) -> f64 {
    if order == 0 {
        return phi(k, z);
    }
    phi_derivative(k, order - 1, z) - f64::from(k) * phi_derivative(k + 1, order - 1, z)
}

fn stumpff(k: u32, s: f64) -> f64 {
    match k {
        1 if s == 0.0 => 1.0,
        1 => {
            let root = libm::sqrt(s.abs());
            let odd = if s > 0.0 { libm::sin } else { libm::sinh };
            odd(root) / root
        }
        // (1 − cos √s)/s = ½ c₁(s/4)², without the cancellation.
        2 => {
            let half = stumpff(1, s / 4.0);
            half * half / 2.0
        }
        _ if s.abs() <= SERIES => series(-s, k, 2),
        _ => (1.0 / factorial(k - 2) - stumpff(k - 2, s)) / s,
    }
}

fn stumpff_derivative(k: u32, order: u32, s: f64) -> f64 {
    if order == 0 {
        return stumpff(k, s);
    }
    let upper = f64::from(k) * stumpff_derivative(k + 2, order - 1, s);
    (upper - stumpff_derivative(k + 1, order - 1, s)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::{phi, phi_derivative, stumpff, stumpff_derivative};

    /// The recursions φ_{k+1} = (φ_k − 1/k!)/z and c_{k+2} = (1/k! − c_k)/s across the seam of the
    /// two evaluations, to what their cancellation leaves.
    #[test]
    fn closed_forms_and_series_agree() {
        for at in [-2.0 - 1e-9, -2.0 + 1e-9, 2.0 - 1e-9, 2.0 + 1e-9] {
            for k in 1..5 {
                let factorial: f64 = (1..=k).map(f64::from).product();
                let next = (phi(k, at) - 1.0 / factorial) / at;
                assert!((next / phi(k + 1, at) - 1.0).abs() < 1e-13);
                let next = (1.0 / factorial - stumpff(k, at)) / at;
                assert!((next / stumpff(k + 2, at) - 1.0).abs() < 1e-12);
            }
        }
    }

    /// Central differences, good to δ² ≈ 1e-10 and ulps over δ.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let delta = 1e-5;
        for at in [-7.3, -1.1, -1e-3, 0.0, 1e-9, 0.4, 3.7, 30.0] {
            for order in 0..3 {
                let slope =
                    |f: &dyn Fn(f64) -> f64| (f(at + delta) - f(at - delta)) / (2.0 * delta);
                let exponential = slope(&|z| phi_derivative(1, order, z));
                let expected = phi_derivative(1, order + 1, at);
                assert!(
                    (exponential - expected).abs() <= 1e-8 * expected.abs(),
                    "{at} {order}"
                );
                for k in [1, 2] {
                    let found = slope(&|s| stumpff_derivative(k, order, s));
                    let expected = stumpff_derivative(k, order + 1, at);
                    assert!((found - expected).abs() < 1e-9, "{at} {order} {k}");
                }
            }
        }
    }
}
