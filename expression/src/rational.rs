//! Exact rational numbers: machine words while they fit, arbitrary precision beyond.
//!
//! A value is always in lowest terms with a positive denominator, and is held in machine words
//! exactly when numerator and denominator both fit `i64`; equality and hashing compare this one
//! representation.

mod arithmetic;
mod conversion;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

use num_bigint::BigInt;
use num_traits::{One, Signed, ToPrimitive, Zero};

pub use conversion::{DIGIT_LIMIT, DecimalError, EXPONENT_LIMIT};

type BigRatio = num_rational::Ratio<BigInt>;

/// An exact rational number of arbitrary precision.
///
/// ```
/// use leafwise_expression::rational::Rational;
///
/// let third = Rational::new(1, 3);
/// let tenth = Rational::parse_decimal("0.1").expect("a decimal");
/// assert_eq!((third + tenth).to_string(), "13/30");
/// ```
#[derive(Clone)]
pub struct Rational(Representation);

#[derive(Clone)]
enum Representation {
    /// Lowest terms, positive denominator.
    Small(i64, i64),
    /// Lowest terms, positive denominator, numerator or denominator outside `i64`.
    Big(Box<BigRatio>),
}

use Representation::{Big, Small};

impl Rational {
    /// The number `numerator / denominator`.
    ///
    /// # Panics
    /// When `denominator` is zero.
    pub fn new(numerator: i64, denominator: i64) -> Self {
        assert!(denominator != 0, "a rational number with denominator zero");
        Self::from_wide(i128::from(numerator), i128::from(denominator))
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
            Big(ratio) => ratio.denom().is_one(),
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
            Big(ratio) if ratio.numer().is_negative() => -1,
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

    /// The binary digits of the longer of numerator and denominator.
    pub fn bits(&self) -> u64 {
        match &self.0 {
            Small(numerator, denominator) => {
                let longer = numerator.unsigned_abs().max(denominator.unsigned_abs());
                u64::from(u64::BITS - longer.leading_zeros())
            }
            Big(ratio) => ratio.numer().bits().max(ratio.denom().bits()),
        }
    }

    /// The numerator in lowest terms; it carries the sign.
    pub fn numerator(&self) -> BigInt {
        match &self.0 {
            Small(numerator, _) => BigInt::from(*numerator),
            Big(ratio) => ratio.numer().clone(),
        }
    }

    /// The denominator in lowest terms, positive.
    pub fn denominator(&self) -> BigInt {
        match &self.0 {
            Small(_, denominator) => BigInt::from(*denominator),
            Big(ratio) => ratio.denom().clone(),
        }
    }

    /// `numerator / denominator` for a nonzero denominator.
    fn from_wide(numerator: i128, denominator: i128) -> Self {
        let divisor = wide_gcd(numerator.unsigned_abs(), denominator.unsigned_abs());
        let negative = (numerator < 0) != (denominator < 0);
        let numerator = numerator.unsigned_abs() / divisor;
        let denominator = denominator.unsigned_abs() / divisor;
        let small_numerator = if negative {
            0i64.checked_sub_unsigned(u64::try_from(numerator).unwrap_or(u64::MAX))
        } else {
            i64::try_from(numerator).ok()
        };
        match (small_numerator, i64::try_from(denominator)) {
            (Some(numerator), Ok(denominator)) => Self(Small(numerator, denominator)),
            _ => {
                let magnitude = BigInt::from(numerator);
                let signed = if negative { -magnitude } else { magnitude };
                Self(Big(Box::new(BigRatio::new_raw(
                    signed,
                    BigInt::from(denominator),
                ))))
            }
        }
    }

    /// `ratio`, which is in lowest terms, in the representation that fits it.
    fn from_ratio(ratio: BigRatio) -> Self {
        match (ratio.numer().to_i64(), ratio.denom().to_i64()) {
            (Some(numerator), Some(denominator)) => Self(Small(numerator, denominator)),
            _ => Self(Big(Box::new(ratio))),
        }
    }

    fn to_ratio(&self) -> BigRatio {
        match &self.0 {
            Small(numerator, denominator) => {
                BigRatio::new_raw(BigInt::from(*numerator), BigInt::from(*denominator))
            }
            Big(ratio) => ratio.as_ref().clone(),
        }
    }
}

/// The greatest common divisor; `b` is not zero.
fn gcd(mut a: u64, mut b: u64) -> u64 {
    while a != 0 {
        (a, b) = (b % a, a);
    }
    b
}

/// The greatest common divisor; `b` is not zero. Continues in one machine word as soon as it can.
fn wide_gcd(mut a: u128, mut b: u128) -> u128 {
    while a != 0 {
        if let (Ok(a), Ok(b)) = (u64::try_from(a), u64::try_from(b)) {
            return u128::from(gcd(a, b));
        }
        (a, b) = (b % a, a);
    }
    b
}

impl PartialEq for Rational {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Small(a, b), Small(c, d)) => a == c && b == d,
            (Big(a), Big(b)) => a.numer() == b.numer() && a.denom() == b.denom(),
            _ => false,
        }
    }
}

impl Eq for Rational {}

impl Hash for Rational {
    fn hash<S: Hasher>(&self, state: &mut S) {
        match &self.0 {
            Small(numerator, denominator) => {
                numerator.hash(state);
                denominator.hash(state);
            }
            Big(ratio) => {
                ratio.numer().hash(state);
                ratio.denom().hash(state);
            }
        }
    }
}

impl Ord for Rational {
    fn cmp(&self, other: &Self) -> Ordering {
        if let (Small(a, b), Small(c, d)) = (&self.0, &other.0) {
            return (i128::from(*a) * i128::from(*d)).cmp(&(i128::from(*c) * i128::from(*b)));
        }
        let (left, right) = (self.to_ratio(), other.to_ratio());
        (left.numer() * right.denom()).cmp(&(right.numer() * left.denom()))
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

impl From<BigInt> for Rational {
    fn from(value: BigInt) -> Self {
        Self::from_ratio(BigRatio::from_integer(value))
    }
}

impl fmt::Display for Rational {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Small(numerator, 1) => write!(formatter, "{numerator}"),
            Small(numerator, denominator) => write!(formatter, "{numerator}/{denominator}"),
            Big(ratio) if ratio.denom().is_one() => write!(formatter, "{}", ratio.numer()),
            Big(ratio) => write!(formatter, "{}/{}", ratio.numer(), ratio.denom()),
        }
    }
}

impl fmt::Debug for Rational {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

impl Zero for Rational {
    fn zero() -> Self {
        Self::from_integer(0)
    }

    fn is_zero(&self) -> bool {
        Rational::is_zero(self)
    }
}

impl One for Rational {
    fn one() -> Self {
        Self::from_integer(1)
    }
}
