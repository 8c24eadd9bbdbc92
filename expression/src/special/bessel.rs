//! Derivatives of Bessel functions of whole order.

/// J_ν⁽ᵏ⁾(x) = 2⁻ᵏ Σ_j (−1)ʲ C(k, j) J_{ν−k+2j}(x) (NIST Handbook of Mathematical Functions, 10.6.7).
pub(super) fn derivative(nu: i32, order: u32, x: f64) -> f64 {
    let k = order as i32;
    let mut sum = 0.0;
    let mut binomial = 1.0;
    for j in 0..=k {
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        sum += sign * binomial * of_order(nu - k + 2 * j, x);
        binomial = binomial * f64::from(k - j) / f64::from(j + 1);
    }
    libm::ldexp(sum, -k)
}

/// J_n(x), of a negative n too.
fn of_order(n: i32, x: f64) -> f64 {
    let value = match n.abs() {
        0 => libm::j0(x),
        1 => libm::j1(x),
        n => libm::jn(n, x),
    };
    if n < 0 && n % 2 != 0 { -value } else { value }
}
