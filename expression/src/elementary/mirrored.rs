//! eˣ − 1 and e⁻ˣ − 1 at once.
//!
//! x = k ln 2 + r with |r| ≤ ½ ln 2. The powers of r², taken once, make sinh r and cosh r − 1; their
//! sum and difference are e^{±r} − 1, where the larger of the two, r itself, is added last. So both
//! are within 1 ulp for k = 0 and within 2 ulps elsewhere, where 2ᵏ(eʳ − 1) + (2ᵏ − 1) cancels by at
//! most a third.

use super::lanes::{ElementaryPair, value_of_pair};
use super::reduction::{exponent, nearest, sextic};
use crate::vector::Register;

/// eˣ − 1 and e⁻ˣ − 1.
pub(super) struct Mirrored;

/// 1/3!, 1/5!, …, 1/13!: sinh r = r + r³ Σ_j r²ʲ/(2j + 3)! to 3e-19 of r.
const ODD: [f64; 6] = [
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5_040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
];

/// 1/4!, 1/6!, …, 1/14!: cosh r − 1 = ½r² + r⁴ Σ_j r²ʲ/(2j + 4)!.
const EVEN: [f64; 6] = [
    1.0 / 24.0,
    1.0 / 720.0,
    1.0 / 40_320.0,
    1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    1.0 / 87_178_291_200.0,
];

/// e^{±(r + low)} − 1 for |r| ≤ ½ ln 2 and what r lacks.
#[inline(always)]
fn near<R: Register>(r: R, low: R) -> (R, R) {
    let square = r * r;
    let odd = (r * square) * sextic(square, ODD) + low;
    let even = R::splat(0.5) * square + (square * square) * sextic(square, EVEN);
    (r + (even + odd), (even - odd) - r)
}

impl ElementaryPair for Mirrored {
    /// Ordinary where neither value overflows.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R, R::Mask) {
        const LN_2_HIGH: u64 = 0x3fe6_2e42_fee0_0000;
        const LN_2_LOW: u64 = 0x3dea_39ef_3579_3c76;
        const INVERSE_LN_2: u64 = 0x3ff7_1547_652b_82fe;
        /// A little below ½ ln 2: here k = 0, and the way round gives the same.
        const NEAR: f64 = 0.3465;
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let is_near = x.abs().less(R::splat(NEAR));
        if R::all(is_near) {
            let (up, down) = near(x, zero);
            return (up, down, is_near);
        }
        let k = nearest(R::bits(INVERSE_LN_2) * x);
        let high = x - k * R::bits(LN_2_HIGH);
        let low = k * R::bits(LN_2_LOW);
        let r = high - low;
        let (up, down) = near(r, (high - r) - low);
        let power = one.add_bits(exponent(k));
        let inverse = one.add_bits(exponent(zero - k));
        (
            power * up + (power - one),
            inverse * down + (inverse - one),
            x.abs().less(R::splat(700.0)),
        )
    }

    fn any(x: f64) -> (f64, f64) {
        value_of_pair::<Self>(x).unwrap_or_else(|| (libm::expm1(x), libm::expm1(-x)))
    }
}
