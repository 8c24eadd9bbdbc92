//! eˣ by fdlibm's `e_exp.c`.
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
