//! Eight doubles in a register of AVX-512.

use std::arch::x86_64::*;

use super::register::{Register, operator};

/// Eight doubles.
#[derive(Clone, Copy)]
pub(crate) struct Eight(__m512d);

operator!(Eight, Add, add, _mm512_add_pd);
operator!(Eight, Sub, sub, _mm512_sub_pd);
operator!(Eight, Mul, mul, _mm512_mul_pd);
operator!(Eight, Div, div, _mm512_div_pd);

impl Register for Eight {
    type Mask = __mmask8;
    const LANES: usize = 8;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: registers are made only inside of functions of their instruction set.
        Self(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        let values: &[f64; 8] = values.first_chunk().expect("a register of numbers");
        // SAFETY: as above; the array is as long as the register.
        Self(unsafe { _mm512_loadu_pd(values.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        let values: &mut [f64; 8] = values.first_chunk_mut().expect("a register of numbers");
        // SAFETY: as above; the array is as long as the register.
        unsafe { _mm512_storeu_pd(values.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn times_plus(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_fmadd_pd(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn times_from(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_fnmadd_pd(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn larger(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_max_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        // SAFETY: as above.
        unsafe { _mm512_reduce_max_pd(self.0) }
    }

    #[inline(always)]
    fn less(self, b: Self) -> __mmask8 {
        // SAFETY: as above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, b.0) }
    }

    #[inline(always)]
    fn equal(self, b: Self) -> __mmask8 {
        // SAFETY: as above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(self.0, b.0) }
    }

    #[inline(always)]
    fn is_odd(self) -> __mmask8 {
        // SAFETY: as above.
        unsafe { _mm512_test_epi64_mask(_mm512_castpd_si512(self.0), _mm512_set1_epi64(1)) }
    }

    #[inline(always)]
    fn select(mask: __mmask8, a: Self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_mask_blend_pd(mask, b.0, a.0) })
    }

    #[inline(always)]
    fn all(mask: __mmask8) -> bool {
        mask == __mmask8::MAX
    }

    #[inline(always)]
    fn and(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_and_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn or(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_or_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn xor(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_xor_pd(self.0, b.0) })
    }

    #[inline(always)]
    fn add_bits(self, b: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe {
            let (a, b) = (_mm512_castpd_si512(self.0), _mm512_castpd_si512(b.0));
            _mm512_castsi512_pd(_mm512_add_epi64(a, b))
        })
    }

    #[inline(always)]
    fn up<const K: u32>(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_castsi512_pd(_mm512_slli_epi64::<K>(_mm512_castpd_si512(self.0))) })
    }

    #[inline(always)]
    fn down<const K: u32>(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_castsi512_pd(_mm512_srli_epi64::<K>(_mm512_castpd_si512(self.0))) })
    }
}
