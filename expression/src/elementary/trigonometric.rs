//! sin, cos and tan by fdlibm's `e_rem_pio2.c`, `k_sin.c`, `k_cos.c` and `k_tan.c`.
//!
//! Arguments are reduced to x = n π/2 + r with |r| ≤ π/4, r = high + low. Odd and even polynomials
//! of r follow.

use super::lanes::{Elementary, ElementaryPair};
use super::reduction::{SHIFTER, horner};
use crate::vector::{Fused, Register, SIGN};

/// An argument's n (in the low bits of `quadrant`) and r = high + low.
pub(super) struct Reduced<R: Register> {
    pub(super) quadrant: R,
    pub(super) high: R,
    pub(super) low: R,
    /// Whether `libm` reduces it so.
    pub(super) agrees: R::Mask,
}

/// Reduces x by n times the first 33 bits of π/2 and by the rest, one subtraction each, good to 85
/// bits.
///
/// Two cases are not ordinary here. Where r is so small that this is not enough, `libm` goes on.
/// Near odd multiples of π/4 it chooses n by the high word of x.
#[inline(always)]
pub(super) fn reduce<R: Register>(x: R) -> Reduced<R> {
    const TWO_OVER_PI: u64 = 0x3fe4_5f30_6dc9_c883;
    const HALF_PI_HIGH: u64 = 0x3ff9_21fb_5440_0000;
    const HALF_PI_LOW: u64 = 0x3dd0_b461_1a62_6331;
    /// 2²⁰ π/2 in its high word, beyond which the reduction takes more words.
    const LARGE: u64 = 0x4139_21fb_0000_0000;
    /// 2⁻¹⁵, less an ulp: r then is at most 16 binary digits smaller than x.
    const CANCELLED: u64 = 0x3eff_ffff_ffff_ffff;
    /// The high words of odd multiples of π/4 up to 9π/4 are within 2⁻¹⁸ of them.
    const NEAR_HALF: f64 = 0.499_99;
    let t = x * R::bits(TWO_OVER_PI);
    let quadrant = t + R::splat(SHIFTER);
    let n = quadrant - R::splat(SHIFTER);
    let first = x - n * R::bits(HALF_PI_HIGH);
    let second = n * R::bits(HALF_PI_LOW);
    let high = first - second;
    let low = (first - high) - second;
    let size = x.abs();
    let is_zero = size.equal(R::splat(0.0));
    let agrees = size.less(R::bits(LARGE))
        & (t - n).abs().less(R::splat(NEAR_HALF))
        & ((size * R::bits(CANCELLED)).less(high.abs()) | is_zero);
    Reduced {
        quadrant,
        high,
        low,
        agrees,
    }
}

impl<R: Register> Reduced<R> {
    /// sin r. `libm` has a shorter form for |x| ≤ π/4, where n = 0 and r = x.
    #[inline(always)]
    fn sine(&self, x: R) -> R {
        const S1: u64 = 0xbfc5_5555_5555_5549;
        const NEAR: [u64; 3] = [
            0x3f81_1111_1110_f8a6,
            0xbf2a_01a0_19c1_61d5,
            0x3ec7_1de3_57b1_fe7d,
        ];
        const FAR: [u64; 2] = [0xbe5a_e5e6_8a2b_9ceb, 0x3de5_d93a_5acf_d57c];
        /// 2⁻²⁶, below which the sine is its argument.
        const TINY: u64 = 0x3e50_0000_0000_0000;
        /// The first number with a higher high word than π/4.
        const QUARTER_PI: u64 = 0x3fe9_21fc_0000_0000;
        let Self { high: r, low, .. } = *self;
        let z = r * r;
        let w = z * z;
        let tail = horner(z, NEAR) + z * w * horner(z, FAR);
        let v = z * r;
        let alone = r + v * (R::bits(S1) + z * tail);
        let correction = z * (R::splat(0.5) * low - v * tail) - low;
        let with_low = r - (correction - v * R::bits(S1));
        let size = x.abs();
        let sine = R::select(size.less(R::bits(QUARTER_PI)), alone, with_low);
        R::select(size.less(R::bits(TINY)), x, sine)
    }

    /// cos r.
    #[inline(always)]
    fn cosine(&self) -> R {
        const NEAR: [u64; 3] = [
            0x3fa5_5555_5555_554c,
            0xbf56_c16c_16c1_5177,
            0x3efa_01a0_19cb_1590,
        ];
        const FAR: [u64; 3] = [
            0xbe92_7e4f_809c_52ad,
            0x3e21_ee9e_bdb4_b1c4,
            0xbda8_fae9_be88_38d4,
        ];
        let one = R::splat(1.0);
        let Self { high: r, low, .. } = *self;
        let z = r * r;
        let w = z * z;
        let tail = z * horner(z, NEAR) + w * w * horner(z, FAR);
        let half = R::splat(0.5) * z;
        let w = one - half;
        w + (((one - w) - half) + (z * tail - r * low))
    }

    /// tan r for even n, −cot r for odd n.
    #[inline(always)]
    fn tangent(&self) -> R {
        const T0: u64 = 0x3fd5_5555_5555_5563;
        const ODD: [u64; 6] = [
            0x3fc1_1111_1110_fe7a,
            0x3f96_64f4_8406_d637,
            0x3f6d_6d22_c956_0328,
            0x3f43_44d8_f2f2_6501,
            0x3f14_7e88_a037_92a6,
            0xbef3_75cb_db60_5373,
        ];
        const EVEN: [u64; 6] = [
            0x3fab_a1ba_1bb3_41fe,
            0x3f82_26e3_e96e_8493,
            0x3f57_dbc8_fee0_8315,
            0x3f30_26f7_1a8d_1068,
            0x3f12_b80f_32f0_a7e9,
            0x3efb_2a70_74bf_7ad4,
        ];
        const QUARTER_PI_HIGH: u64 = 0x3fe9_21fb_5444_2d18;
        const QUARTER_PI_LOW: u64 = 0x3c81_a626_3314_5c07;
        /// Below, at 0.6744, the tangent comes from r itself, then from π/4 − |r|.
        const BIG: u64 = 0x3fe5_9428_0000_0000;
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let Self {
            high,
            low,
            quadrant,
            ..
        } = *self;
        let is_odd = quadrant.is_odd();
        let is_small = high.abs().less(R::bits(BIG));
        let sign = one.with_sign_of(high);
        let complement =
            (R::bits(QUARTER_PI_HIGH) - high.abs()) + (R::bits(QUARTER_PI_LOW) - low * sign);
        let r = R::select(is_small, high, complement);
        let low = R::select(is_small, low, zero);
        let z = r * r;
        let w = z * z;
        let tail = horner(w, ODD) + z * horner(w, EVEN);
        let s = z * r;
        let tail = low + z * (s * tail + low) + s * R::bits(T0);
        let w = r + tail;
        let parity = R::select(is_odd, R::splat(-1.0), one);
        let at_big = sign * (parity - two * (r + (tail - w * w / (w + parity))));
        // −1/(r + tail) to the last bit.
        let w0 = without_low_word(w);
        let v = tail - (w0 - r);
        let a = R::splat(-1.0) / w;
        let a0 = without_low_word(a);
        let cotangent = a0 + a * (one + a0 * w0 + a0 * v);
        R::select(is_small, R::select(is_odd, cotangent, w), at_big)
    }
}

#[inline(always)]
fn without_low_word<R: Register>(x: R) -> R {
    x.and(R::bits(0xffff_ffff_0000_0000))
}

/// −a where bit 1 of `quadrant` is set.
#[inline(always)]
pub(super) fn signed<R: Register>(a: R, quadrant: R) -> R {
    a.xor(quadrant.up::<62>().and(R::bits(SIGN)))
}

/// sin x and cos x.
pub(super) struct SinCos;

impl ElementaryPair for SinCos {
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R, R::Mask) {
        let reduced = reduce(x);
        let (sine, cosine) = (reduced.sine(x), reduced.cosine());
        let n = reduced.quadrant;
        let is_odd = n.is_odd();
        (
            signed(R::select(is_odd, cosine, sine), n),
            signed(R::select(is_odd, sine, cosine), n.add_bits(R::bits(1))),
            reduced.agrees,
        )
    }

    fn any<F: Fused>(x: f64) -> (f64, f64) {
        libm::sincos(x)
    }
}

/// sin x.
pub(super) struct Sin;

impl Elementary for Sin {
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        let (sine, _, ordinary) = SinCos::ordinary(x);
        (sine, ordinary)
    }

    fn any(x: f64) -> f64 {
        libm::sin(x)
    }
}

/// cos x.
pub(super) struct Cos;

impl Elementary for Cos {
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        let (_, cosine, ordinary) = SinCos::ordinary(x);
        (cosine, ordinary)
    }

    fn any(x: f64) -> f64 {
        libm::cos(x)
    }
}

/// tan x.
pub(super) struct Tan;

impl Elementary for Tan {
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        /// 2⁻²⁷, below which the tangent is its argument.
        const TINY: u64 = 0x3e40_0000_0000_0000;
        let reduced = reduce(x);
        let is_tiny = x.abs().less(R::bits(TINY));
        (R::select(is_tiny, x, reduced.tangent()), reduced.agrees)
    }

    fn any(x: f64) -> f64 {
        libm::tan(x)
    }
}
