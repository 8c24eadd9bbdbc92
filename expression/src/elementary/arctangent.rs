//! arctan x by fdlibm's `s_atan.c`.
//!
//! arctan |x| = arctan b + arctan (|x| − b)/(1 + b|x|) with b of 0, ½, 1, 3/2, ∞ the nearest.

use super::lanes::Elementary;
use super::reduction::horner;
use crate::vector::Register;

/// arctan x.
pub(super) struct Atan;

impl Elementary for Atan {
    /// Ordinary below 2⁶⁶, where the value becomes π/2.
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        const ODD: [u64; 6] = [
            0x3fd5_5555_5555_550d,
            0x3fc2_4924_9200_83ff,
            0x3fb7_45cd_c54c_206e,
            0x3fb1_0d66_a0d0_3d51,
            0x3fa9_7b4b_2476_0deb,
            0x3f90_ad3a_e322_da11,
        ];
        const EVEN: [u64; 5] = [
            0xbfc9_9999_9998_ebc4,
            0xbfbc_71c6_fe23_1671,
            0xbfb3_b0f2_af74_9a6d,
            0xbfad_de2d_52de_fd9a,
            0xbfa2_b444_2c6a_6c2f,
        ];
        /// arctan b.
        const HIGH: [u64; 5] = [
            0,
            0x3fdd_ac67_0561_bb4f,
            0x3fe9_21fb_5444_2d18,
            0x3fef_730b_d281_f69b,
            0x3ff9_21fb_5444_2d18,
        ];
        const LOW: [u64; 5] = [
            0,
            0x3c7a_2b7f_222f_65e2,
            0x3c81_a626_3314_5c07,
            0x3c70_0788_7af0_cbbd,
            0x3c91_a626_3314_5c07,
        ];
        let (one, two, three_halves) = (R::splat(1.0), R::splat(2.0), R::splat(1.5));
        let a = x.abs();
        let below_half = a.less(R::splat(0.4375));
        let below = [0.6875, 1.1875, 2.4375].map(|limit| a.less(R::splat(limit)));
        let choose = |values: [R; 5]| {
            let value = R::select(below[2], values[3], values[4]);
            let value = R::select(below[1], values[2], value);
            let value = R::select(below[0], values[1], value);
            R::select(below_half, values[0], value)
        };
        let above = choose([a, two * a - one, a - one, a - three_halves, R::splat(-1.0)]);
        let under = choose([one, two + a, a + one, one + three_halves * a, a]);
        let u = above / under;
        let z = u * u;
        let w = z * z;
        let tail = u * (z * horner(w, ODD) + w * horner(w, EVEN));
        let (high, low) = (choose(HIGH.map(R::bits)), choose(LOW.map(R::bits)));
        let value = R::select(below_half, u - tail, high - (tail - low - u));
        let is_far_from_pole = a.less(R::splat(73_786_976_294_838_206_464.0));
        (value.with_sign_of(x), is_far_from_pole)
    }

    fn any(x: f64) -> f64 {
        libm::atan(x)
    }
}
