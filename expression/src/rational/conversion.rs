//! Rational numbers from decimal text and from doubles, and the single rounding to a double.

use dashu_int::UBig;
use dashu_int::ops::{BitTest, DivRem, UnsignedAbs};

use super::{Big, Fraction, Rational, Small};

/// The largest magnitude of the exponent written in a decimal.
pub const EXPONENT_LIMIT: i64 = 400;

/// The largest number of digits of a decimal; every double's exact expansion is shorter.
pub const DIGIT_LIMIT: usize = 2000;

/// Why a text is not a decimal this crate reads.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecimalError {
    /// The text is not `digits[.digits][e[±]digits]`.
    #[error("`{text}` is not a decimal number; write it as 3, 0.1 or 1.5e-3")]
    Malformed {
        /// The text, cut after 40 characters.
        text: String,
    },
    /// The exponent is outside ±[`EXPONENT_LIMIT`].
    #[error("the exponent of `{text}` is outside the range -400 to 400")]
    ExponentOutOfRange {
        /// The text, cut after 40 characters.
        text: String,
    },
    /// The number has more than [`DIGIT_LIMIT`] digits.
    #[error("a decimal of {digits} digits; at most 2000 are read")]
    TooManyDigits {
        /// How many digits stand before the exponent.
        digits: usize,
    },
}

impl Rational {
    /// Exact value of a decimal: optional sign, digits with at most one point, optional exponent
    /// of ten.
    ///
    /// # Errors
    /// Fails with [`DecimalError`] when the text has another form. Fails with it, too, for an
    /// exponent outside ±400 or more than 2000 digits.
    pub fn parse_decimal(text: &str) -> Result<Self, DecimalError> {
        let shown = || text.chars().take(40).collect::<String>();
        let malformed = || DecimalError::Malformed { text: shown() };
        let (negative, unsigned) = match text.as_bytes().first() {
            Some(b'-') => (true, &text[1..]),
            Some(b'+') => (false, &text[1..]),
            _ => (false, text),
        };
        let (mantissa, exponent) = match unsigned.find(['e', 'E']) {
            Some(at) => (&unsigned[..at], Some(&unsigned[at + 1..])),
            None => (unsigned, None),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = whole.len() + fraction.len();
        let all_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if digits == 0 || !all_digits(whole) || !all_digits(fraction) {
            return Err(malformed());
        }
        if digits > DIGIT_LIMIT {
            return Err(DecimalError::TooManyDigits { digits });
        }
        let exponent = match exponent {
            None => 0,
            Some(part) => {
                let unsigned = part.strip_prefix(['+', '-']).unwrap_or(part);
                if unsigned.is_empty() || !all_digits(unsigned) {
                    return Err(malformed());
                }
                match part.parse::<i64>() {
                    Ok(value) if value.abs() <= EXPONENT_LIMIT => value,
                    _ => return Err(DecimalError::ExponentOutOfRange { text: shown() }),
                }
            }
        };
        let joined = [whole, fraction].concat();
        let magnitude = UBig::from_str_radix(&joined, 10).map_err(|_| malformed())?;
        let scale = Self::from_integer(10).powi(exponent - fraction.len() as i64);
        let value = Self::from(magnitude) * scale;
        Ok(if negative { -value } else { value })
    }

    /// The exact value of a finite double; `None` for NaN and the infinities.
    pub fn from_f64(value: f64) -> Option<Self> {
        if !value.is_finite() {
            return None;
        }
        let bits = value.to_bits();
        let biased = (bits >> 52 & 0x7ff) as i64;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let mantissa = if biased == 0 {
            fraction
        } else {
            fraction | 1 << 52
        };
        let signed = if value.is_sign_negative() {
            -mantissa
        } else {
            mantissa
        };
        let scale = Self::from_integer(2).powi(biased.max(1) - 1075);
        Some(Self::from_integer(signed) * scale)
    }

    /// The nearest double, ties to even: one rounding, also among the subnormal numbers. Beyond
    /// the largest double the result is infinite.
    pub fn to_f64(&self) -> f64 {
        const EXACT: u64 = 1 << 53;
        let magnitude = match &self.0 {
            Small(numerator, denominator) => {
                let (n, d) = (numerator.unsigned_abs(), denominator.unsigned_abs());
                if n <= EXACT && d <= EXACT {
                    return *numerator as f64 / *denominator as f64;
                }
                small_ratio(u128::from(n), u128::from(d))
            }
            Big(fraction) => big_ratio(fraction),
        };
        if self.is_negative() {
            -magnitude
        } else {
            magnitude
        }
    }
}

/// The shift that leaves 57 or 58 bits in the integer quotient of numbers of these lengths.
fn quotient_shift(numerator_bits: u64, denominator_bits: u64) -> i64 {
    57 + denominator_bits as i64 - numerator_bits as i64
}

fn small_ratio(numerator: u128, denominator: u128) -> f64 {
    let bits = |value: u128| u64::from(128 - value.leading_zeros());
    let shift = quotient_shift(bits(numerator), bits(denominator));
    let (n, d) = if shift >= 0 {
        (numerator << shift, denominator)
    } else {
        (numerator, denominator << -shift)
    };
    round(u64::try_from(n / d).unwrap_or(u64::MAX), n % d != 0, shift)
}

fn big_ratio(fraction: &Fraction) -> f64 {
    let numerator = (&fraction.numerator).unsigned_abs();
    let denominator = &fraction.denominator;
    let shift = quotient_shift(numerator.bit_len() as u64, denominator.bit_len() as u64);
    let places = shift.unsigned_abs() as usize;
    let (quotient, remainder) = if shift >= 0 {
        (numerator << places).div_rem(denominator)
    } else {
        numerator.div_rem(denominator << places)
    };
    let quotient = u64::try_from(quotient).unwrap_or(u64::MAX);
    round(quotient, !remainder.is_zero(), shift)
}

/// The double nearest to `(quotient + δ) 2^−shift`, where 0 < δ < 1 when `inexact` and δ = 0
/// otherwise; `quotient` has 57 or 58 bits.
fn round(quotient: u64, inexact: bool, shift: i64) -> f64 {
    let bits = i64::from(64 - quotient.leading_zeros());
    let exponent = bits - 1 - shift;
    if exponent > 1023 {
        return f64::INFINITY;
    }
    let precision = 53 - (-1022 - exponent).max(0);
    if precision < 0 {
        return 0.0;
    }
    let dropped = bits - precision;
    let mantissa = quotient >> dropped;
    let remainder = quotient - (mantissa << dropped);
    let half = 1u64 << (dropped - 1);
    let up = remainder > half || (remainder == half && (inexact || mantissa & 1 == 1));
    // A carry out of the mantissa runs into the exponent field, which is the right result.
    let biased = (exponent.max(-1022) + 1022) as u64;
    f64::from_bits((biased << 52) + mantissa + u64::from(up))
}
