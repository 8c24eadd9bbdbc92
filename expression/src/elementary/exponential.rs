//! eˣ and eˣ − 1 by fdlibm's `e_exp.c` and `s_expm1.c`.
//!
//! x = k ln 2 + r with |r| ≤ ½ ln 2; the exponential of r from a rational function of r².

use super::lanes::Elementary;
use super::reduction::{exponent, horner, nearest};
use crate::vector::Register;

/// An argument's k and r = high − low.
struct Reduced<R: Register> {
    k: R,
    high: R,
    low: R,
    /// Whether `libm` finds the same k: it rounds x/ln 2 ± ½ towards zero, which is the nearest
    /// integer but at a tie.
    agrees: R::Mask,
}

#[inline(always)]
fn reduce<R: Register>(x: R) -> Reduced<R> {
    const LN_2_HIGH: u64 = 0x3fe6_2e42_fee0_0000;
    const LN_2_LOW: u64 = 0x3dea_39ef_3579_3c76;
    const INVERSE_LN_2: u64 = 0x3ff7_1547_652b_82fe;
    /// Below, a little above ½ ln 2, `libm` takes k = 0.
    const REDUCED_FROM: u64 = 0x3fd6_2e43_0000_0000;
    let t = R::bits(INVERSE_LN_2) * x;
    let n = nearest(t);
    let k = R::select(x.abs().less(R::bits(REDUCED_FROM)), R::splat(0.0), n);
    Reduced {
        k,
        high: x - k * R::bits(LN_2_HIGH),
        low: k * R::bits(LN_2_LOW),
        agrees: (t - n).abs().less(R::splat(0.5)),
    }
}

/// eˣ.
pub(super) struct Exp;

impl Elementary for Exp {
    /// Ordinary where the result is a normal number.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        const P: [u64; 5] = [
            0x3fc5_5555_5555_553e,
            0xbf66_c16c_16be_bd93,
            0x3f11_566a_af25_de2c,
            0xbebb_bd41_c5d2_6bf1,
            0x3e66_3769_72be_a4d0,
        ];
        /// Below, where the high word is at most that of 2⁻²⁸, the value is 1 + x.
        const LINEAR_BELOW: u64 = 0x3e30_0001_0000_0000;
        let (one, two) = (R::splat(1.0), R::splat(2.0));
        let Reduced {
            k,
            high,
            low,
            agrees,
        } = reduce(x);
        let r = high - low;
        let square = r * r;
        let c = r - square * horner(square, P);
        let y = one + (r * c / (two - c) - low + high);
        let y = R::select(x.abs().less(R::bits(LINEAR_BELOW)), one + x, y);
        let is_normal = x.abs().less(R::splat(708.0));
        (y.add_bits(exponent(k)), is_normal & agrees)
    }

    fn any(x: f64) -> f64 {
        libm::exp(x)
    }
}

/// eˣ − 1.
pub(super) struct ExpMinus1;

impl Elementary for ExpMinus1 {
    /// Ordinary between −56 ln 2, below which the value is −1, and overflow.
    ///
    /// The five forms of `s_expm1.c` are four here: those of k = −1, of 0, and of 1 with r ≥ −¼
    /// round as the one of 2 ≤ k < 20 does.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        const Q: [u64; 6] = [
            0x3ff0_0000_0000_0000,
            0xbfa1_1111_1111_10f4,
            0x3f5a_01a0_19fe_5585,
            0xbf14_ce19_9eaa_dbb7,
            0x3ed0_cfca_86e6_5239,
            0xbe8a_fdb7_6e09_c32d,
        ];
        let one = R::splat(1.0);
        let Reduced {
            k,
            high,
            low,
            agrees,
        } = reduce(x);
        let r = high - low;
        let c = (high - r) - low;
        let half = R::splat(0.5) * r;
        let square = r * half;
        let r1 = horner(square, Q);
        let t = R::splat(3.0) - r1 * half;
        let e = square * ((r1 - t) / (R::splat(6.0) - r * t));
        let e = (r * (e - c) - c) - square;
        // 2ᵏ(r − e + 1) − 1, the sum in the order that cancels least.
        let inverse = one.add_bits(exponent(R::splat(0.0) - k));
        let less_1 = inverse - one;
        let difference = r - e;
        let far = k.less(R::splat(-1.0)) | R::splat(56.0).less(k);
        let below = k.equal(one) & r.less(R::splat(-0.25));
        let sum = R::select(below, (r - less_1) - e, difference - less_1);
        let large = (r - (e + inverse)) + one;
        let sum = R::select(R::splat(19.5).less(k), large, sum);
        let sum = R::select(far, difference + one, sum);
        let value = sum * one.add_bits(exponent(k));
        let value = R::select(far, value - one, value);
        let is_between = R::splat(-38.8).less(x) & x.less(R::splat(709.0));
        (value, is_between & agrees)
    }

    fn any(x: f64) -> f64 {
        libm::expm1(x)
    }
}
