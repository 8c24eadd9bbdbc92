//! Complete elliptic integrals of the parameter m = k² and their derivatives, for m < 1.
//!
//! Values come from the arithmetic-geometric mean (NIST Handbook of Mathematical Functions, 19.8). The n-th derivative is
//! c F(a + n, b + n; 1 + n; m). Here F is hypergeometric, a = b = ½ of K and a = −½ of E, and c is
//! π/2 Π_{j<n} (a + j)(b + j)/(1 + j). For m in [−16, ½], and below for high n, the series of F serves, below 0
//! after Pfaff's transformation (15.8.1). Elsewhere the differential equation (15.10.1) gives a recurrence.

use std::f64::consts::{FRAC_PI_2, PI};

/// Arithmetic-geometric means converge quadratically: after so many steps for every pair of doubles.
const STEPS: u32 = 20;

/// Down to −m of this size the series serves, of 650 terms at most; below it a recurrence loses a few units an order.
const NEAR: f64 = 16.0;

/// Steps of the recurrence, for each unit of −m, in which its error grows tenfold or less.
const RECURRENCES: f64 = 2.0;

use super::scaled::Scaled;

/// K⁽ⁿ⁾(m).
pub(super) fn first_kind(order: u32, m: f64) -> f64 {
    if order == 0 {
        return both(m).0;
    }
    derivative(order, m, 0.5)
}

/// E⁽ⁿ⁾(m).
pub(super) fn second_kind(order: u32, m: f64) -> f64 {
    if order == 0 {
        return both(m).1;
    }
    derivative(order, m, -0.5)
}

/// K(m) and E(m).
fn both(m: f64) -> (f64, f64) {
    if m == 1.0 {
        return (f64::INFINITY, 1.0);
    }
    if m == f64::NEG_INFINITY {
        return (0.0, f64::INFINITY);
    }
    // NaN above 1.
    let (mut a, mut b) = (1.0, libm::sqrt(1.0 - m));
    let (mut sum, mut power) = (0.5 * m, 0.5);
    for _ in 0..STEPS {
        let half = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
        power *= 2.0;
        sum += power * half * half;
    }
    let k = PI / (2.0 * a);
    (k, k * (1.0 - sum))
}

/// The derivative of order n ≥ 1 of π/2 F(a, ½; 1; m).
fn derivative(n: u32, m: f64, a: f64) -> f64 {
    // All coefficients of powers of m are of one sign.
    let pole = if a > 0.0 {
        f64::INFINITY
    } else {
        f64::NEG_INFINITY
    };
    if m == 1.0 {
        return pole;
    }
    if m == f64::NEG_INFINITY {
        return 0.0;
    }
    if m > 1.0 || m.is_nan() {
        return f64::NAN;
    }
    // The recurrence grows by 1 − 1/m each time beside the derivatives.
    let is_near = m >= -NEAR || -m * RECURRENCES < f64::from(n);
    if m <= 0.5 && is_near {
        let mut factor = Scaled::new(FRAC_PI_2);
        for j in 0..n {
            let j = f64::from(j);
            factor = factor * Scaled::new((a + j) * (0.5 + j) / (1.0 + j));
        }
        let (power, n) = (n as i32, f64::from(n));
        let (lower, b, c) = (a + n, 0.5 + n, 1.0 + n);
        if m >= 0.0 {
            return (factor * Scaled::new(series(lower, b, c, m))).value();
        }
        let transformed = Scaled::power(1.0 - m, -power) * Scaled::new(libm::pow(1.0 - m, -a));
        let series = series(lower, c - b, c, m / (m - 1.0));
        return (factor * transformed * Scaled::new(series)).value();
    }
    let (k, e) = both(m);
    let (mut value, mut slope) = if a > 0.0 {
        (k, (e - (1.0 - m) * k) / (2.0 * m * (1.0 - m)))
    } else {
        (e, (e - k) / (2.0 * m))
    };
    for j in 0..n - 1 {
        let j = f64::from(j);
        // m(1 − m) y″ + (c − (a + b + 1)m) y′ = a b y of the j-th derivative, with c = 1 + j, a + j and ½ + j.
        let (a, b) = (a + j, 0.5 + j);
        let next = (a * b * value - (1.0 + j - (a + b + 1.0) * m) * slope) / (m * (1.0 - m));
        (value, slope) = (slope, next);
    }
    // Past the largest number, differences of such are none.
    if slope.is_finite() { slope } else { pole }
}

/// F(a, b; c; z) for 0 ≤ z < 1, of about 36/(1 − z) terms.
fn series(a: f64, b: f64, c: f64, z: f64) -> f64 {
    let (mut sum, mut term, mut k) = (1.0, 1.0, 0.0);
    loop {
        term *= (a + k) * (b + k) / ((c + k) * (k + 1.0)) * z;
        k += 1.0;
        let next = sum + term;
        // The first terms may grow: a, b and c are next to each other.
        if next == sum || !next.is_finite() {
            return next;
        }
        sum = next;
    }
}
