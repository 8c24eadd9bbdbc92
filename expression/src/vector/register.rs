//! Registers of doubles with the operations that elementary functions are made of.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// A number of doubles on which every operation acts lane by lane, rounded once as IEEE 754 says:
/// no lane knows of the others.
///
/// An implementation belongs to an instruction set. Its values are made and used only inside of
/// functions of that set, to which [`run_on_registers`](super::run_on_registers) hands the type.
pub trait Register:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A truth value for each lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;
    /// The number of lanes.
    const LANES: usize;

    /// The same number in each lane.
    fn splat(value: f64) -> Self;
    /// The first [`Register::LANES`] of `values`.
    fn load(values: &[f64]) -> Self;
    /// Writes the first [`Register::LANES`] of `values`.
    fn store(self, values: &mut [f64]);

    /// a·b + c, rounded once.
    fn times_plus(self, b: Self, c: Self) -> Self;
    /// c − a·b, rounded once.
    fn times_from(self, b: Self, c: Self) -> Self;

    /// The larger of a and b; b where one is NaN.
    fn larger(self, b: Self) -> Self;
    /// The largest lane of numbers ≥ 0.
    fn largest(self) -> f64;
    /// Whether a < b; false for NaN.
    fn less(self, b: Self) -> Self::Mask;
    /// Whether a = b; false for NaN.
    fn equal(self, b: Self) -> Self::Mask;
    /// Whether bit 0 is set.
    fn is_odd(self) -> Self::Mask;
    /// a in the lanes of `mask`, b in the others.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Whether the mask holds in every lane.
    fn all(mask: Self::Mask) -> bool;

    /// The bits that both have.
    fn and(self, b: Self) -> Self;
    /// The bits that at least one has.
    fn or(self, b: Self) -> Self;
    /// The bits that exactly one has.
    fn xor(self, b: Self) -> Self;
    /// The bits' sum as integers modulo 2⁶⁴.
    fn add_bits(self, b: Self) -> Self;
    /// The bits K places up.
    fn up<const K: u32>(self) -> Self;
    /// The bits K places down.
    fn down<const K: u32>(self) -> Self;

    /// These bits in each lane.
    #[inline(always)]
    fn bits(bits: u64) -> Self {
        Self::splat(f64::from_bits(bits))
    }

    /// |a|.
    #[inline(always)]
    fn abs(self) -> Self {
        self.and(Self::bits(!SIGN))
    }

    /// |a| with the sign of b.
    #[inline(always)]
    fn with_sign_of(self, b: Self) -> Self {
        self.abs().or(b.and(Self::bits(SIGN)))
    }
}

/// The bit of the sign.
pub(crate) const SIGN: u64 = 1 << 63;

/// A binary operator by an intrinsic.
#[cfg(target_arch = "x86_64")]
macro_rules! operator {
    ($register:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl std::ops::$trait for $register {
            type Output = Self;

            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                // SAFETY: a register exists only inside of functions of its instruction set.
                Self(unsafe { $intrinsic(self.0, b.0) })
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
pub(super) use operator;
