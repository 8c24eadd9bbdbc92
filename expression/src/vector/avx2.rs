//! Four doubles in a register of AVX2.

use std::arch::x86_64::*;

use super::register::{Register, operator};

/// Four doubles.
#[derive(Clone, Copy)]
pub(crate) struct Four(__m256d);

/// Four truth values: all bits of a lane, or none.
#[derive(Clone, Copy)]
pub(crate) struct FourMasks(__m256d);

operator!(Four, Add, add, _mm256_add_pd);
operator!(Four, Sub, sub, _mm256_sub_pd);
operator!(Four, Mul, mul, _mm256_mul_pd);
operator!(Four, Div, div, _mm256_div_pd);
operator!(FourMasks, BitAnd, bitand, _mm256_and_pd);
operator!(FourMasks, BitOr, bitor, _mm256_or_pd);

impl Register for Four {
    type Mask = FourMasks;
    const LANES: usize = 4;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: registers are made only inside of functions of their instruction set.
        Self(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        let values: &[f64; 4] = values.first_chunk().expect("a register of numbers");
        // SAFETY: as above; the array is as long as the register.
        Self(unsafe { _mm256_loadu_pd(values.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        let values: &mut [f64; 4] = values.first_chunk_mut().expect("a register of numbers");
        // SAFETY: as above; the array is as long as the register.
        unsafe { _mm256_storeu_pd(values.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn times_plus(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_fmadd_pd(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn times_from(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_fnmadd_pd(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn larger(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_max_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        // SAFETY: as above.
        unsafe {
            let halves = [
                _mm256_castpd256_pd128(self.0),
                _mm256_extractf128_pd::<1>(self.0),
            ];
            let pairs = _mm_max_pd(halves[0], halves[1]);
            _mm_cvtsd_f64(_mm_max_sd(pairs, _mm_unpackhi_pd(pairs, pairs)))
        }
    }

    #[inline(always)]
    fn less(self, b: Self) -> FourMasks {
        // SAFETY: as above.
        FourMasks(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, b.0) })
    }

    #[inline(always)]
    fn equal(self, b: Self) -> FourMasks {
        // SAFETY: as above.
        FourMasks(unsafe { _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, b.0) })
    }

    #[inline(always)]
    fn is_odd(self) -> FourMasks {
        let sign = self.up::<63>();
        // SAFETY: as above.
        FourMasks(unsafe {
            let negative = _mm256_cmpgt_epi64(_mm256_setzero_si256(), _mm256_castpd_si256(sign.0));
            _mm256_castsi256_pd(negative)
        })
    }

    #[inline(always)]
    fn select(mask: FourMasks, a: Self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_blendv_pd(b.0, a.0, mask.0) })
    }

    #[inline(always)]
    fn all(mask: FourMasks) -> bool {
        // SAFETY: as above.
        unsafe { _mm256_movemask_pd(mask.0) == 0b1111 }
    }

    #[inline(always)]
    fn and(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_and_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn or(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_or_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn xor(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_xor_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn add_bits(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe {
            let (a, b) = (_mm256_castpd_si256(self.0), _mm256_castpd_si256(b.0));
            _mm256_castsi256_pd(_mm256_add_epi64(a, b))
        })
    }

    #[inline(always)]
    fn up<const K: u32>(self) -> Self {
        // SAFETY: as above.
        Self(unsafe {
            let places = _mm_cvtsi32_si128(K as i32);
            _mm256_castsi256_pd(_mm256_sll_epi64(_mm256_castpd_si256(self.0), places))
        })
    }

    #[inline(always)]
    fn down<const K: u32>(self) -> Self {
        // SAFETY: as above.
        Self(unsafe {
            let places = _mm_cvtsi32_si128(K as i32);
            _mm256_castsi256_pd(_mm256_srl_epi64(_mm256_castpd_si256(self.0), places))
        })
    }
}
