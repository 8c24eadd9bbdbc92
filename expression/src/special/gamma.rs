//! ln|Γ| and its derivatives, the polygamma functions.
//!
//! Above y = 17 + n the asymptotic series of ψ⁽ⁿ⁾ serves, below it ψ⁽ⁿ⁾(x) = ψ⁽ⁿ⁾(x + 1) − (−1)ⁿ n!/xⁿ⁺¹. For x < 0 it is
//! the reflection ψ⁽ⁿ⁾(x) = (−1)ⁿ ψ⁽ⁿ⁾(1 − x) − π dⁿ/dxⁿ cot πx: nothing of the size of the poles cancels. The source is the
//! NIST Handbook of Mathematical Functions, 5.11.2, 5.5.2, 5.15.5, 5.15.6 and 5.15.8.

use std::f64::consts::PI;

use super::scaled::Scaled;

/// B₂, B₄, …, B₂₄.
const BERNOULLI: [f64; 12] = [
    1.0 / 6.0,
    -1.0 / 30.0,
    1.0 / 42.0,
    -1.0 / 30.0,
    5.0 / 66.0,
    -691.0 / 2730.0,
    7.0 / 6.0,
    -3617.0 / 510.0,
    43_867.0 / 798.0,
    -174_611.0 / 330.0,
    854_513.0 / 138.0,
    -236_364_091.0 / 2730.0,
];

/// The k-th derivative of ln|Γ| at x: the digamma function for k = 1, ψ⁽ᵏ⁻¹⁾ for more. At a pole it is infinite where both
/// sides agree, at ±0 as the sign says, and else no number.
pub(super) fn ln_gamma(order: u32, x: f64) -> f64 {
    if order == 0 {
        return libm::lgamma(x);
    }
    let n = order - 1;
    if x > 0.0 {
        return polygamma(n, x).value();
    }
    // −½ to ½, without rounding.
    let rest = x - libm::rint(x);
    let is_odd = n % 2 == 1;
    if rest == 0.0 {
        return match (is_odd, x == 0.0) {
            (true, _) => f64::INFINITY,
            (false, true) => -1.0 / x,
            (false, false) => f64::NAN,
        };
    }
    if rest.is_nan() {
        return f64::NAN;
    }
    let mirrored = polygamma(n, 1.0 - x);
    let difference = periodic(n, rest) - mirrored;
    if is_odd {
        difference.value()
    } else {
        (-difference).value()
    }
}

/// ψ⁽ⁿ⁾(x) of x > 0.
fn polygamma(n: u32, x: f64) -> Scaled {
    let is_odd = n % 2 == 1;
    if x == f64::INFINITY {
        return Scaled::new(if n == 0 { x } else { 0.0 });
    }
    // Σ 1/(x + j)ⁿ⁺¹, the smallest terms first.
    let far = 17.0 + f64::from(n);
    let steps = if x < far { libm::ceil(far - x) } else { 0.0 };
    let mut below = Scaled::ZERO;
    let mut j = steps;
    while j > 0.0 {
        j -= 1.0;
        below = below + Scaled::power(x + j, -(n as i32 + 1));
    }
    let y = x + steps;
    if n == 0 {
        return Scaled::new(digamma(y)) - below;
    }
    let far = Scaled::factorial(n - 1) * Scaled::power(y, -(n as i32)) * Scaled::new(series(n, y));
    let size = far + Scaled::factorial(n) * below;
    if is_odd { size } else { -size }
}

/// ψ(y) for y of 17 at least.
fn digamma(y: f64) -> f64 {
    let square = 1.0 / (y * y);
    let (mut sum, mut power) = (0.0, 1.0);
    for (j, b) in (1..).zip(BERNOULLI) {
        power *= square;
        sum += b * power / (2.0 * f64::from(j));
    }
    libm::log(y) - 0.5 / y - sum
}

/// yⁿ |ψ⁽ⁿ⁾(y)|/(n − 1)! for n > 0 and y of 17 + n at least.
fn series(n: u32, y: f64) -> f64 {
    let square = 1.0 / (y * y);
    // (2j + n − 1)!/((2j)! (n − 1)!) y^(−2j).
    let (mut sum, mut power) = (0.0, 1.0);
    let n = f64::from(n);
    for (j, b) in (1..).zip(BERNOULLI) {
        let even = 2.0 * f64::from(j);
        power *= square * (even + n - 1.0) * (even + n - 2.0) / (even * (even - 1.0));
        sum += b * power;
    }
    1.0 + 0.5 * n / y + sum
}

/// n! Σ 1/(f + k)ⁿ⁺¹ over all whole k, (−1)ⁿ π dⁿ/dfⁿ cot πf, for 0 < |f| ≤ ½.
fn periodic(n: u32, f: f64) -> Scaled {
    let is_odd = n % 2 == 1;
    let size = f.abs();
    let sign = |positive: Scaled| match f < 0.0 && !is_odd {
        true => -positive,
        false => positive,
    };
    if size > 0.25 {
        // Next to its zero at ½ the cotangent keeps its digits.
        let cotangent = libm::tan(PI * (0.5 - size));
        let polynomial = Scaled::new(derivative_of_cotangent(n, cotangent));
        return sign(Scaled::factorial(n) * Scaled::power(PI, n as i32 + 1) * polynomial);
    }
    if n == 0 {
        return sign(Scaled::new(PI / libm::tan(PI * size)));
    }
    let own = Scaled::factorial(n) * Scaled::power(size, -(n as i32 + 1));
    let [above, below] = [1.0 + size, 1.0 - size].map(|at| polygamma(n, at));
    sign(if is_odd {
        own + above + below
    } else {
        own - above + below
    })
}

/// (−1)ⁿ/n! dⁿ/duⁿ cot u by c = cot u ≥ 0: a polynomial with no negative coefficient, pₙ₊₁ = (1 + c²) pₙ′/(n + 1).
fn derivative_of_cotangent(n: u32, c: f64) -> f64 {
    let mut coefficients = vec![0.0, 1.0];
    for k in 1..=n {
        let mut next = vec![0.0; coefficients.len() + 1];
        for (power, coefficient) in coefficients.iter().enumerate().skip(1) {
            let slope = power as f64 * coefficient / f64::from(k);
            next[power - 1] += slope;
            next[power + 1] += slope;
        }
        coefficients = next;
    }
    let coefficients = coefficients.iter().rev();
    coefficients.fold(0.0, |sum, coefficient| sum * c + coefficient)
}
