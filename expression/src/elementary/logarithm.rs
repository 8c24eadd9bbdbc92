//! ln x by fdlibm's `e_log.c`.
//!
//! x = 2ᵏ(1 + f) with √½ < 1 + f < √2; the logarithm of 1 + f from s = f/(2 + f).

use super::lanes::Elementary;
use super::reduction::horner;
use crate::vector::Register;

/// ln x.
pub(super) struct Ln;

impl Elementary for Ln {
    /// Ordinary for positive normal numbers (but the first and the last).
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        const LN_2_HIGH: u64 = 0x3fe6_2e42_fee0_0000;
        const LN_2_LOW: u64 = 0x3dea_39ef_3579_3c76;
        const ODD: [u64; 4] = [
            0x3fe5_5555_5555_5593,
            0x3fd2_4924_9422_9359,
            0x3fc7_4664_96cb_03de,
            0x3fc2_f112_df3e_5244,
        ];
        const EVEN: [u64; 3] = [
            0x3fd9_9999_9997_fa04,
            0x3fcc_71c5_1d8e_78af,
            0x3fc3_9a09_d078_c69f,
        ];
        /// √½ in its high word.
        const ROOT_HALF: u64 = 0x3fe6_a09e << 32;
        const ONE: u64 = 0x3ff0_0000 << 32;
        const MANTISSA: u64 = (1 << 52) - 1;
        /// 2⁵²: the integers below are its low bits.
        const UNIT: f64 = 4_503_599_627_370_496.0;

        let shifted = x.add_bits(R::bits(ONE - ROOT_HALF));
        // The exponent as a number: 2⁵² + (k + 1023), less both.
        let k = shifted.down::<52>().or(R::splat(UNIT)) - R::splat(UNIT + 1023.0);
        let mantissa = shifted.and(R::bits(MANTISSA));
        let f = mantissa.add_bits(R::bits(ROOT_HALF)) - R::splat(1.0);
        let half_square = R::splat(0.5) * f * f;
        let s = f / (R::splat(2.0) + f);
        let z = s * s;
        let w = z * z;
        let r = z * horner(w, ODD) + w * horner(w, EVEN);
        let value = s * (half_square + r) + k * R::bits(LN_2_LOW) - half_square
            + f
            + k * R::bits(LN_2_HIGH);
        let is_normal = R::splat(f64::MIN_POSITIVE).less(x) & x.less(R::splat(f64::MAX));
        (value, is_normal)
    }

    fn any(x: f64) -> f64 {
        libm::log(x)
    }
}
