//! Fractions of big integers in lowest terms.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::ops::Div;

use dashu_int::ops::{BitTest, Gcd};
use dashu_int::{IBig, Sign, UBig};

/// `numerator / denominator` in lowest terms.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct Fraction {
    pub(super) numerator: IBig,
    /// Never zero.
    pub(super) denominator: UBig,
}

impl Fraction {
    /// The binary digits of the longer of numerator and denominator.
    pub(super) fn bits(&self) -> u64 {
        self.numerator.bit_len().max(self.denominator.bit_len()) as u64
    }

    pub(super) fn negated(&self) -> Self {
        Self {
            numerator: -&self.numerator,
            denominator: self.denominator.clone(),
        }
    }

    /// 1/a for a nonzero a.
    pub(super) fn reciprocal(&self) -> Self {
        let (sign, magnitude) = self.numerator.clone().into_parts();
        Self {
            numerator: sign * IBig::from(self.denominator.clone()),
            denominator: magnitude,
        }
    }

    /// a/b · c/d = (a/g · c/h) / (b/h · d/g) with g = gcd(a, d) and h = gcd(c, b).
    pub(super) fn product(&self, other: &Self) -> Self {
        let g = (&self.numerator).gcd(&other.denominator);
        let h = (&other.numerator).gcd(&self.denominator);
        Self {
            numerator: &*quotient(&self.numerator, &g) * &*quotient(&other.numerator, &h),
            denominator: &*quotient(&self.denominator, &h) * &*quotient(&other.denominator, &g),
        }
    }

    /// a/b + c/d = (t/h) / (b/h · d/g) with g = gcd(b, d), t = a·d/g + c·b/g and h = gcd(t, g).
    pub(super) fn sum(&self, other: &Self) -> Self {
        let g = (&self.denominator).gcd(&other.denominator);
        let b = quotient(&self.denominator, &g);
        let d = quotient(&other.denominator, &g);
        let t = &self.numerator * &*d + &other.numerator * &*b;
        let h = (&t).gcd(&g);
        Self {
            denominator: &*quotient(&self.denominator, &h) * &*d,
            numerator: if h.is_one() { t } else { t / h },
        }
    }

    /// How a/b stands to c/d: as a·d to c·b.
    pub(super) fn compare(&self, other: &Self) -> Ordering {
        (&self.numerator * &other.denominator).cmp(&(&other.numerator * &self.denominator))
    }

    pub(super) fn is_negative(&self) -> bool {
        self.numerator.sign() == Sign::Negative
    }
}

/// The dividend over one of its divisors.
fn quotient<'a, N: Clone>(dividend: &'a N, divisor: &UBig) -> Cow<'a, N>
where
    for<'d> &'a N: Div<&'d UBig, Output = N>,
{
    if divisor.is_one() {
        Cow::Borrowed(dividend)
    } else {
        Cow::Owned(dividend / divisor)
    }
}
