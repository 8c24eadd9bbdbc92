//! One double, on every machine.

use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Sub};

use super::fused::Fused;
use super::register::Register;

/// One double, its fused products by F.
#[derive(Clone, Copy)]
pub(crate) struct One<F>(pub(crate) f64, PhantomData<F>);

macro_rules! operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl<F> $trait for One<F> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                Self(self.0 $operator b.0, PhantomData)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<F> One<F> {
    #[inline(always)]
    fn of_bits(bits: u64) -> Self {
        Self(f64::from_bits(bits), PhantomData)
    }
}

impl<F: Fused> Register for One<F> {
    type Mask = bool;
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(value, PhantomData)
    }

    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        Self(values[0], PhantomData)
    }

    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        values[0] = self.0;
    }

    #[inline(always)]
    fn times_plus(self, b: Self, c: Self) -> Self {
        Self(F::times_plus(self.0, b.0, c.0), PhantomData)
    }

    #[inline(always)]
    fn times_from(self, b: Self, c: Self) -> Self {
        Self(F::times_plus(-self.0, b.0, c.0), PhantomData)
    }

    #[inline(always)]
    fn larger(self, b: Self) -> Self {
        if self.0 > b.0 { self } else { b }
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        self.0
    }

    #[inline(always)]
    fn less(self, b: Self) -> bool {
        self.0 < b.0
    }

    #[inline(always)]
    fn equal(self, b: Self) -> bool {
        self.0 == b.0
    }

    #[inline(always)]
    fn is_odd(self) -> bool {
        self.0.to_bits() & 1 == 1
    }

    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn all(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn and(self, b: Self) -> Self {
        Self::of_bits(self.0.to_bits() & b.0.to_bits())
    }

    #[inline(always)]
    fn or(self, b: Self) -> Self {
        Self::of_bits(self.0.to_bits() | b.0.to_bits())
    }

    #[inline(always)]
    fn xor(self, b: Self) -> Self {
        Self::of_bits(self.0.to_bits() ^ b.0.to_bits())
    }

    #[inline(always)]
    fn add_bits(self, b: Self) -> Self {
        Self::of_bits(self.0.to_bits().wrapping_add(b.0.to_bits()))
    }

    #[inline(always)]
    fn up<const K: u32>(self) -> Self {
        Self::of_bits(self.0.to_bits() << K)
    }

    #[inline(always)]
    fn down<const K: u32>(self) -> Self {
        Self::of_bits(self.0.to_bits() >> K)
    }
}
