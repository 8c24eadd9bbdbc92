//! Exact rational numbers: machine words while they fit, arbitrary precision beyond.
//!
//! A value is always in lowest terms with a positive denominator. It is held in machine words
//! exactly when numerator and denominator both fit `i64`. Equality and hashing compare this one
//! representation.

mod arithmetic;
mod conversion;
mod fraction;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::cmp::Ordering;
use std::fmt;

use dashu_int::ops::DivEuclid;
use dashu_int::{IBig, UBig};

pub use conversion::{DIGIT_LIMIT, DecimalError, EXPONENT_LIMIT};

use fraction::Fraction;

/// An exact rational number of arbitrary precision.
///
/// ```
/// use leafwise_expression::rational::Rational;
///
/// let third = Rational::new(1, 3);
/// let tenth = Rational::parse_decimal("0.1").expect("a decimal");
/// assert_eq!((third + tenth).to_string(), "13/30");
/// ```
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Rational(Representation);

#[derive(Clone, PartialEq, Eq, Hash)]
enum Representation {
    /// Lowest terms, positive denominator.
    Small(i64, i64),
    /// Lowest terms, positive denominator, numerator or denominator outside `i64`.
    Big(Box<Fraction>),
}

use Representation::{Big, Small};

impl Rational {
    /// The number `numerator / denominator`.
    ///
    /// # Panics
    /// When `denominator` is zero.
    pub fn new(numerator: i64, denominator: i64) -> Self {
        assert!(denominator != 0, "a rational number with denominator zero");
        let divisor = gcd(numerator, denominator) * i128::from(denominator.signum());
        Self::from_wide(
            i128::from(numerator) / divisor,
            i128::from(denominator) / divisor,
        )
    }

    /// The integer `value`.
    pub const fn from_integer(value: i64) -> Self {
        Self(Small(value, 1))
    }

    /// The number 0.
    pub const fn zero() -> Self {
        Self::from_integer(0)
    }

    /// The number 1.
    pub const fn one() -> Self {
        Self::from_integer(1)
    }

    /// Whether the number is 0.
    pub fn is_zero(&self) -> bool {
        matches!(self.0, Small(0, _))
    }

    /// Whether the number is 1.
    pub fn is_one(&self) -> bool {
        matches!(self.0, Small(1, 1))
    }

    /// Whether the denominator is 1.
    pub fn is_integer(&self) -> bool {
        match &self.0 {
            Small(_, denominator) => *denominator == 1,
            Big(fraction) => fraction.denominator.is_one(),
        }
    }

    /// Whether the number is below 0.
    pub fn is_negative(&self) -> bool {
        self.signum() < 0
    }

    /// −1, 0 or 1, by sign.
    pub fn signum(&self) -> i32 {
        match &self.0 {
            Small(numerator, _) => numerator.signum() as i32,
            Big(fraction) if fraction.is_negative() => -1,
            Big(_) => 1,
        }
    }

    /// The number as an `i64`, when it is an integer of that range.
    pub fn to_i64(&self) -> Option<i64> {
        match self.0 {
            Small(numerator, 1) => Some(numerator),
            _ => None,
        }
    }

    /// The largest integer that is not above the number.
    pub fn floor(&self) -> Self {
        match &self.0 {
            Small(numerator, denominator) => Self::from_integer(numerator.div_euclid(*denominator)),
            Big(fraction) => {
                let denominator = IBig::from(fraction.denominator.clone());
                Self::from_fraction(Fraction {
                    numerator: fraction.numerator.clone().div_euclid(denominator),
                    denominator: UBig::ONE,
                })
            }
        }
    }

    /// The binary digits of the longer of numerator and denominator.
    pub fn bits(&self) -> u64 {
        match &self.0 {
            Small(numerator, denominator) => {
                let longer = numerator.unsigned_abs().max(denominator.unsigned_abs());
                u64::from(u64::BITS - longer.leading_zeros())
            }
            Big(fraction) => fraction.bits(),
        }
    }

    /// The numerator in lowest terms; it carries the sign.
    pub fn numerator(&self) -> IBig {
        self.fraction().into_owned().numerator
    }

    /// The denominator in lowest terms, positive.
    pub fn denominator(&self) -> UBig {
        self.fraction().into_owned().denominator
    }

    /// Numerator and denominator in lowest terms, the latter positive, where both fit.
    pub(crate) fn as_words(&self) -> Option<(i128, i128)> {
        match &self.0 {
            Small(numerator, denominator) => {
                Some((i128::from(*numerator), i128::from(*denominator)))
            }
            Big(fraction) => {
                let numerator = i128::try_from(&fraction.numerator).ok()?;
                let denominator = i128::try_from(&fraction.denominator).ok()?;
                Some((numerator, denominator))
            }
        }
    }

    /// `numerator / denominator` for a positive denominator.
    pub(crate) fn from_words(numerator: i128, denominator: i128) -> Self {
        let (mut divisor, mut rest) = (denominator, numerator % denominator);
        while rest != 0 {
            if let (Ok(a), Ok(b)) = (i64::try_from(divisor), i64::try_from(rest)) {
                divisor = gcd(a, b);
                break;
            }
            (divisor, rest) = (rest, divisor % rest);
        }
        let divisor = divisor.abs();
        Self::from_wide(numerator / divisor, denominator / divisor)
    }

    /// `numerator / denominator`, which is in lowest terms with a positive denominator.
    fn from_wide(numerator: i128, denominator: i128) -> Self {
        match (i64::try_from(numerator), i64::try_from(denominator)) {
            (Ok(numerator), Ok(denominator)) => Self(Small(numerator, denominator)),
            _ => Self(Big(Box::new(Fraction {
                numerator: IBig::from(numerator),
                denominator: UBig::from(denominator.unsigned_abs()),
            }))),
        }
    }

    /// `fraction` in the representation that fits it.
    fn from_fraction(fraction: Fraction) -> Self {
        match (
            i64::try_from(&fraction.numerator),
            i64::try_from(&fraction.denominator),
        ) {
            (Ok(numerator), Ok(denominator)) => Self(Small(numerator, denominator)),
            _ => Self(Big(Box::new(fraction))),
        }
    }

    /// The number as a fraction of big integers.
    fn fraction(&self) -> Cow<'_, Fraction> {
        match &self.0 {
            Small(numerator, denominator) => Cow::Owned(Fraction {
                numerator: IBig::from(*numerator),
                denominator: UBig::from(denominator.unsigned_abs()),
            }),
            Big(fraction) => Cow::Borrowed(fraction),
        }
    }
}

/// The greatest common divisor; gcd(0, b) = |b|.
///
/// One division brings the numbers to one length, then Stein's algorithm shifts and subtracts.
fn gcd(a: i64, b: i64) -> i128 {
    let (a, b) = (a.unsigned_abs(), b.unsigned_abs());
    let (shorter, longer) = (a.min(b), a.max(b));
    if shorter == 0 {
        return i128::from(longer);
    }
    let rest = longer % shorter;
    if rest == 0 {
        return i128::from(shorter);
    }
    let twos = (rest | shorter).trailing_zeros();
    let (mut a, mut b) = (
        rest >> rest.trailing_zeros(),
        shorter >> shorter.trailing_zeros(),
    );
    while a != b {
        let difference = a.abs_diff(b);
        b = a.min(b);
        a = difference >> difference.trailing_zeros();
    }
    i128::from(a) << twos
}

impl Ord for Rational {
    fn cmp(&self, other: &Self) -> Ordering {
        if let (Small(a, b), Small(c, d)) = (&self.0, &other.0) {
            return (i128::from(*a) * i128::from(*d)).cmp(&(i128::from(*c) * i128::from(*b)));
        }
        self.fraction().compare(&other.fraction())
    }
}

impl PartialOrd for Rational {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Default for Rational {
    fn default() -> Self {
        Self::zero()
    }
}

impl From<i64> for Rational {
    fn from(value: i64) -> Self {
        Self::from_integer(value)
    }
}

impl From<UBig> for Rational {
    fn from(value: UBig) -> Self {
        Self::from_fraction(Fraction {
            numerator: IBig::from(value),
            denominator: UBig::ONE,
        })
    }
}

impl fmt::Display for Rational {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Small(numerator, 1) => write!(formatter, "{numerator}"),
            Small(numerator, denominator) => write!(formatter, "{numerator}/{denominator}"),
            Big(fraction) if self.is_integer() => write!(formatter, "{}", fraction.numerator),
            Big(fraction) => {
                write!(formatter, "{}/{}", fraction.numerator, fraction.denominator)
            }
        }
    }
}

impl fmt::Debug for Rational {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}
