//! sin x and 1 − cos x at once: what a rotation adds to a vector.
//!
//! x = n π/2 + r with |r| ≤ π/4, and the polynomials of fdlibm's `k_sin.c` and `k_cos.c`, whose terms are
//! added in an order that lets them be computed side by side. 1 − cos x is formed without
//! cancellation. Both are within 2 ulps: ½r² is rounded to half an ulp of its own, which is a whole one of
//! ½r² − r⁴/24 + … in the binade below, and the difference to another half.

use super::lanes::{ElementaryPair, value_of_pair};
use super::reduction::sextic;
use super::trigonometric::{reduce, signed};
use crate::vector::Register;

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

/// sin and 1 − cos of r + low for |r| ≤ π/4 and what r lacks.
#[inline(always)]
fn near<R: Register>(r: R, low: R) -> (R, R) {
    let square = r * r;
    let half = R::splat(0.5) * square;
    let odd = (r * square) * sextic(square, SINE) + (low - low * half);
    let even = (square * square) * sextic(square, COSINE) - r * low;
    (r + odd, half - even)
}

impl ElementaryPair for Turn {
    /// Ordinary where the reduction is good to all bits.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R, R::Mask) {
        /// A little below π/4: here n = 0, and the way round gives the same.
        const NEAR: f64 = 0.785;
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let is_near = x.abs().less(R::splat(NEAR));
        if R::all(is_near) {
            let (sine, versine) = near(x, zero);
            return (sine, versine, is_near);
        }
        let reduced = reduce(x);
        let (sine, versine) = near(reduced.high, reduced.low);
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

    fn any(x: f64) -> (f64, f64) {
        value_of_pair::<Self>(x).unwrap_or_else(|| {
            let half = libm::sin(0.5 * x);
            (libm::sin(x), 2.0 * half * half)
        })
    }
}
