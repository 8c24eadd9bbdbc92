//! eˣ − 1 and e⁻ˣ − 1 at once.
//!
//! r = x for |x| < 0.55; elsewhere x = k ln 2 + r with |r| ≤ ½ ln 2. The powers of r², taken once, make the parts of
//! e^{±r} that are even and odd in r. In their sum and difference r itself, the largest part, is added last. Both
//! values are within 1 ulp for |x| ≤ ½ ln 2 and within 2 ulps elsewhere. There r and r² (even ± r odd), or 2ᵏ(eʳ − 1)
//! and 2ᵏ − 1, cancel by at most a third.

use super::lanes::{ElementaryPair, value_of_pair};
use super::reduction::{exponent, nearest, septic};
use crate::vector::{Fused, Register};

/// eˣ − 1 and e⁻ˣ − 1.
pub(super) struct Mirrored;

/// 1/3!, 1/5!, …, 1/15!: sinh r = r + r³ Σ_j r²ʲ/(2j + 3)! to 2e-19 of r.
const ODD: [f64; 7] = [
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5_040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
];

/// 1/2!, 1/4!, …, 1/14!: cosh r − 1 = r² Σ_j r²ʲ/(2j + 2)! to 6e-18 of r.
const EVEN: [f64; 7] = [
    1.0 / 2.0,
    1.0 / 24.0,
    1.0 / 720.0,
    1.0 / 40_320.0,
    1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    1.0 / 87_178_291_200.0,
];

/// ±r + r² (even ± r odd): the parts of e^{±r} − 1 for |r| < 0.55. They are r², even + r odd and even − r odd.
struct Parts<R> {
    square: R,
    up: R,
    down: R,
}

#[inline(always)]
fn parts<R: Register>(r: R) -> Parts<R> {
    let square = r * r;
    let fourth = square * square;
    let odd = septic(square, fourth, ODD);
    let even = septic(square, fourth, EVEN);
    Parts {
        square,
        up: r.times_plus(odd, even),
        down: r.times_from(odd, even),
    }
}

impl<R: Register> Parts<R> {
    /// e^{±r} − 1.
    #[inline(always)]
    fn alone(&self, r: R) -> (R, R) {
        let mirrored = R::splat(0.0) - r;
        (
            self.square.times_plus(self.up, r),
            self.square.times_plus(self.down, mirrored),
        )
    }

    /// e^{±(r + low)} − 1, where r lacks low.
    #[inline(always)]
    fn with_low(&self, r: R, low: R) -> (R, R) {
        let mirrored = R::splat(0.0) - low;
        (
            r + self.square.times_plus(self.up, low),
            self.square.times_plus(self.down, mirrored) - r,
        )
    }
}

impl ElementaryPair for Mirrored {
    /// Ordinary where neither value overflows.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R, R::Mask) {
        const LN_2_HIGH: u64 = 0x3fe6_2e42_fee0_0000;
        const LN_2_LOW: u64 = 0x3dea_39ef_3579_3c76;
        const INVERSE_LN_2: u64 = 0x3ff7_1547_652b_82fe;
        /// So far the parts of x itself serve.
        const NEAR: f64 = 0.55;
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let is_near = x.abs().less(R::splat(NEAR));
        if R::all(is_near) {
            let (up, down) = parts(x).alone(x);
            return (up, down, is_near);
        }
        let k = R::select(is_near, zero, nearest(R::bits(INVERSE_LN_2) * x));
        let high = x - k * R::bits(LN_2_HIGH);
        let low = k * R::bits(LN_2_LOW);
        let r = high - low;
        let parts = parts(r);
        let (alone, with_low) = (parts.alone(r), parts.with_low(r, (high - r) - low));
        let up = R::select(is_near, alone.0, with_low.0);
        let down = R::select(is_near, alone.1, with_low.1);
        let power = one.add_bits(exponent(k));
        let inverse = one.add_bits(exponent(zero - k));
        (
            power.times_plus(up, power - one),
            inverse.times_plus(down, inverse - one),
            x.abs().less(R::splat(700.0)),
        )
    }

    #[inline(always)]
    fn any<F: Fused>(x: f64) -> (f64, f64) {
        value_of_pair::<Self, F>(x).unwrap_or_else(|| (libm::expm1(x), libm::expm1(-x)))
    }
}
