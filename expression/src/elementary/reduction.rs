//! Rounding to integers by additions.

use crate::vector::Register;

/// 1.5·2⁵²: a double of this size has the unit 1, so that adding it rounds to the nearest integer.
/// That integer then stands in the low bits as a two's complement number.
pub(super) const SHIFTER: f64 = 6_755_399_441_055_744.0;

/// The nearest integer to t, |t| < 2⁵¹, ties to even.
#[inline(always)]
pub(super) fn nearest<R: Register>(t: R) -> R {
    (t + R::splat(SHIFTER)) - R::splat(SHIFTER)
}

/// Bits of an integer n, |n| < 2⁵¹, in the place of the exponent. The low 51 bits are those of its
/// two's complement. Added to the bits of y they make 2ⁿy, where that is a normal number.
#[inline(always)]
pub(super) fn exponent<R: Register>(n: R) -> R {
    (n + R::splat(SHIFTER)).up::<52>()
}

/// c₀ + z(c₁ + z(c₂ + …)), evaluated from the right.
#[inline(always)]
pub(super) fn horner<R: Register, const N: usize>(z: R, coefficients: [u64; N]) -> R {
    let mut sum = R::bits(coefficients[N - 1]);
    for c in coefficients[..N - 1].iter().rev() {
        sum = R::bits(*c) + z * sum;
    }
    sum
}

/// c₀ + z c₁ + … + z⁶ c₆ from z and z², in three levels instead of six.
#[inline(always)]
pub(super) fn septic<R: Register>(z: R, square: R, c: [f64; 7]) -> R {
    let pair = |at: usize| z.times_plus(R::splat(c[at + 1]), R::splat(c[at]));
    let upper = square.times_plus(R::splat(c[6]), pair(4));
    (square * square).times_plus(upper, square.times_plus(pair(2), pair(0)))
}

/// c₀ + z c₁ + … + z⁵ c₅ from z and z², in three levels instead of five.
#[inline(always)]
pub(super) fn sextic<R: Register>(z: R, square: R, c: [f64; 6]) -> R {
    let pair = |at: usize| z.times_plus(R::splat(c[at + 1]), R::splat(c[at]));
    square.times_plus(square.times_plus(pair(4), pair(2)), pair(0))
}
