//! ln|Γ| and its derivatives, the polygamma functions.
//!
//! Above y = 16 + k the asymptotic series serves, below it ψ⁽ⁿ⁾(x) = ψ⁽ⁿ⁾(x + 1) − (−1)ⁿ n!/xⁿ⁺¹ (NIST Handbook of Mathematical
//! Functions, 5.11.2, 5.5.2, 5.15.5 and 5.15.8).

/// Derivatives have no values below −10⁴: each unit is a step of the recurrence.
const LOWEST: f64 = -1e4;

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

/// The k-th derivative of ln|Γ| at x: the digamma function for k = 1, ψ⁽ᵏ⁻¹⁾ for more.
pub(super) fn ln_gamma(order: u32, x: f64) -> f64 {
    if order == 0 {
        return libm::lgamma(x);
    }
    if x < LOWEST || x.is_nan() {
        return f64::NAN;
    }
    let n = order - 1;
    let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    let factorial: f64 = (1..=n).map(f64::from).product();
    // Σ 1/(x + j)ⁿ⁺¹, the smallest terms first.
    let far = 16.0 + f64::from(order);
    let steps = if x < far { libm::ceil(far - x) } else { 0.0 };
    let mut below = 0.0;
    let mut j = steps;
    while j > 0.0 {
        j -= 1.0;
        below += libm::pow(x + j, -f64::from(order));
    }
    asymptotic(n, x + steps) - sign * factorial * below
}

/// ψ⁽ⁿ⁾(y) for y of 16 + n at least.
fn asymptotic(n: u32, y: f64) -> f64 {
    let square = 1.0 / (y * y);
    // (2j + n − 1)!/((2j)! (n − 1)!) y^(−2j), times (n − 1)! for n > 0.
    let mut sum = 0.0;
    let mut power = 1.0;
    if n == 0 {
        for (j, b) in (1..).zip(BERNOULLI) {
            power *= square;
            sum += b * power / (2.0 * f64::from(j));
        }
        return libm::log(y) - 0.5 / y - sum;
    }
    let n = f64::from(n);
    for (j, b) in (1..).zip(BERNOULLI) {
        let even = 2.0 * f64::from(j);
        power *= square * (even + n - 1.0) * (even + n - 2.0) / (even * (even - 1.0));
        sum += b * power;
    }
    let whole = n as u32;
    let factorial: f64 = (1..whole).map(f64::from).product();
    let sign = if whole.is_multiple_of(2) { -1.0 } else { 1.0 };
    let series = 1.0 + 0.5 * n / y + sum;
    sign * factorial * libm::pow(y, -n) * series
}
