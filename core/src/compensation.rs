//! Sums held as unevaluated pairs of doubles.

/// Knuth's two-sum: s + e = a + b exactly, s = a + b rounded.
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let back = sum - a;
    (sum, (a - (sum - back)) + (b - back))
}
