//! sin x and 1 − cos x at once: what a rotation adds to a vector.
//!
//! Arguments are reduced to x = n π/2 + r with |r| ≤ π/4. The polynomials are those of fdlibm's `k_sin.c` and
//! `k_cos.c`, whose terms are added in an order that lets them be computed side by side. No cancellation
//! occurs in 1 − cos x.
//!
//! Both values are within 2 ulps. Rounding of ½r² costs half an ulp of its own, which is a whole one of ½r² − r⁴/24 +
//! … in the binade below. Rounding of the difference costs another half.

use super::lanes::{ElementaryPair, value_of_pair};
use super::reduction::sextic;
use super::trigonometric::{reduce, signed};
use crate::vector::{Fused, Register};

/// sin x and 1 − cos x.
pub(super) struct Turn;

/// sin r = r + r³ Σ_j S_j r²ʲ to 2⁻⁵⁸ of r.
const SINE: [f64; 6] = [
    f64::from_bits(0xbfc5_5555_5555_5549),
    f64::from_bits(0x3f81_1111_1110_f8a6),
    f64::from_bits(0xbf2a_01a0_19c1_61d5),
    f64::from_bits(0x3ec7_1de3_57b1_fe7d),
    f64::from_bits(0xbe5a_e5e6_8a2b_9ceb),
    f64::from_bits(0x3de5_d93a_5acf_d57c),
];

/// 1 − cos r = ½r² − r⁴ Σ_j C_j r²ʲ to 2⁻⁵⁸.
const COSINE: [f64; 6] = [
    f64::from_bits(0x3fa5_5555_5555_554c),
    f64::from_bits(0xbf56_c16c_16c1_5177),
    f64::from_bits(0x3efa_01a0_19cb_1590),
    f64::from_bits(0xbe92_7e4f_809c_52ad),
    f64::from_bits(0x3e21_ee9e_bdb4_b1c4),
    f64::from_bits(0xbda8_fae9_be88_38d4),
];

/// Terms of sin r and 1 − cos r for |r| ≤ π/4: r³ and r⁴ with their factors, and ½r².
struct Parts<R> {
    cube: R,
    sine: R,
    fourth: R,
    cosine: R,
    half: R,
}

#[inline(always)]
fn parts<R: Register>(r: R) -> Parts<R> {
    let square = r * r;
    let fourth = square * square;
    Parts {
        cube: r * square,
        sine: sextic(square, fourth, SINE),
        fourth,
        cosine: sextic(square, fourth, COSINE),
        half: R::splat(0.5) * square,
    }
}

impl<R: Register> Parts<R> {
    /// sin r and 1 − cos r.
    #[inline(always)]
    fn alone(&self, r: R) -> (R, R) {
        (
            self.cube.times_plus(self.sine, r),
            self.fourth.times_from(self.cosine, self.half),
        )
    }

    /// sin and 1 − cos of r + low, where r lacks low.
    #[inline(always)]
    fn with_low(&self, r: R, low: R) -> (R, R) {
        let odd = self
            .cube
            .times_plus(self.sine, low.times_from(self.half, low));
        let even = self.fourth.times_plus(self.cosine, R::splat(0.0) - r * low);
        (r + odd, self.half - even)
    }
}

impl ElementaryPair for Turn {
    /// Ordinary where the reduction is good to all bits.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R, R::Mask) {
        /// A little below π/4: here n = 0, and r is x.
        const NEAR: f64 = 0.785;
        let one = R::splat(1.0);
        let is_near = x.abs().less(R::splat(NEAR));
        if R::all(is_near) {
            let (sine, versine) = parts(x).alone(x);
            return (sine, versine, is_near);
        }
        let reduced = reduce(x);
        let parts = parts(reduced.high);
        let (alone, with_low) = (
            parts.alone(reduced.high),
            parts.with_low(reduced.high, reduced.low),
        );
        let sine = R::select(is_near, alone.0, with_low.0);
        let versine = R::select(is_near, alone.1, with_low.1);
        let n = reduced.quadrant;
        let (is_odd, is_behind) = (n.is_odd(), n.down::<1>().is_odd());
        // 1 − cos x: 1 − cos r, 1 + sin r, 1 + cos r, 1 − sin r.
        let beside = one + signed(sine, n);
        let along = R::select(is_behind, R::splat(2.0) - versine, versine);
        (
            signed(R::select(is_odd, one - versine, sine), n),
            R::select(is_odd, beside, along),
            reduced.agrees,
        )
    }

    #[inline(always)]
    fn any<F: Fused>(x: f64) -> (f64, f64) {
        value_of_pair::<Self, F>(x).unwrap_or_else(|| {
            let half = libm::sin(0.5 * x);
            (libm::sin(x), 2.0 * half * half)
        })
    }
}
