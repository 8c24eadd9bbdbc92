//! The field operations of [`Rational`].

use std::iter::{Product, Sum};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::{Big, Rational, Small, gcd};

impl Rational {
    /// The reciprocal 1/a.
    ///
    /// # Panics
    /// When the number is zero.
    pub fn recip(&self) -> Self {
        assert!(!self.is_zero(), "the reciprocal of zero");
        match &self.0 {
            Small(numerator, denominator) => Self::new(*denominator, *numerator),
            Big(fraction) => Self::from_fraction(fraction.reciprocal()),
        }
    }

    /// The absolute value |a|.
    pub fn abs(&self) -> Self {
        if self.is_negative() {
            -self
        } else {
            self.clone()
        }
    }

    /// The power a^exponent, with a^0 = 1 for every a.
    ///
    /// The result has up to |exponent| times the digits of the number.
    ///
    /// # Panics
    /// When the number is zero and the exponent negative.
    pub fn powi(&self, exponent: i64) -> Self {
        let mut base = if exponent < 0 {
            self.recip()
        } else {
            self.clone()
        };
        let mut remaining = exponent.unsigned_abs();
        let mut power = Self::one();
        while remaining > 0 {
            if remaining & 1 == 1 {
                power = &power * &base;
            }
            remaining >>= 1;
            if remaining > 0 {
                base = &base * &base;
            }
        }
        power
    }

    /// The quotient self / divisor, `None` when the divisor is zero.
    pub fn checked_div(&self, divisor: &Self) -> Option<Self> {
        if divisor.is_zero() {
            return None;
        }
        Some(self.multiply(&divisor.recip()))
    }

    fn sum(&self, other: &Self) -> Self {
        if let (Small(a, b), Small(c, d)) = (&self.0, &other.0) {
            if *b == 1
                && *d == 1
                && let Some(total) = a.checked_add(*c)
            {
                return Self::from_integer(total);
            }
            let divisor = gcd(*b, *d);
            let (a, b) = (i128::from(*a), i128::from(*b));
            let (c, d) = (i128::from(*c), i128::from(*d) / divisor);
            let numerator = a * d + c * (b / divisor);
            let common = gcd((numerator % divisor) as i64, divisor as i64);
            return Self::from_wide(numerator / common, b / common * d);
        }
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        Self::from_fraction(self.fraction().sum(&other.fraction()))
    }

    fn multiply(&self, other: &Self) -> Self {
        if let (Small(a, b), Small(c, d)) = (&self.0, &other.0) {
            let (left, right) = (gcd(*a, *d), gcd(*c, *b));
            let numerator = over(*a, left) * over(*c, right);
            let denominator = over(*b, right) * over(*d, left);
            return Self::from_wide(numerator, denominator);
        }
        if self.is_one() {
            return other.clone();
        }
        if other.is_one() {
            return self.clone();
        }
        Self::from_fraction(self.fraction().product(&other.fraction()))
    }

    fn divide(&self, divisor: &Self) -> Self {
        self.checked_div(divisor)
            .expect("division of a rational number by zero")
    }

    fn subtract(&self, other: &Self) -> Self {
        self.sum(&-other)
    }
}

/// a/b by one division of words where b fits one.
fn over(a: i64, b: i128) -> i128 {
    match i64::try_from(b) {
        Ok(1) => i128::from(a),
        Ok(b) => i128::from(a / b),
        Err(_) => i128::from(a) / b,
    }
}

macro_rules! operator {
    ($(#[$attribute:meta])* $operator:ident, $method:ident, $function:ident) => {
        $(#[$attribute])*
        impl $operator<&Rational> for &Rational {
            type Output = Rational;
            fn $method(self, other: &Rational) -> Rational {
                self.$function(other)
            }
        }
        $(#[$attribute])*
        impl $operator<Rational> for &Rational {
            type Output = Rational;
            fn $method(self, other: Rational) -> Rational {
                self.$function(&other)
            }
        }
        $(#[$attribute])*
        impl $operator<&Rational> for Rational {
            type Output = Rational;
            fn $method(self, other: &Rational) -> Rational {
                self.$function(other)
            }
        }
        $(#[$attribute])*
        impl $operator<Rational> for Rational {
            type Output = Rational;
            fn $method(self, other: Rational) -> Rational {
                self.$function(&other)
            }
        }
    };
}

operator!(Add, add, sum);
operator!(Sub, sub, subtract);
operator!(Mul, mul, multiply);
operator!(
    /// # Panics
    /// When the divisor is zero; [`Rational::checked_div`] does not.
    Div, div, divide
);

impl Neg for &Rational {
    type Output = Rational;
    fn neg(self) -> Rational {
        match &self.0 {
            Small(numerator, denominator) => match numerator.checked_neg() {
                Some(numerator) => Rational(Small(numerator, *denominator)),
                None => Rational::from_wide(-i128::from(*numerator), i128::from(*denominator)),
            },
            Big(fraction) => Rational::from_fraction(fraction.negated()),
        }
    }
}

impl Neg for Rational {
    type Output = Rational;
    fn neg(self) -> Rational {
        -&self
    }
}

impl AddAssign<&Rational> for Rational {
    fn add_assign(&mut self, other: &Rational) {
        *self = self.sum(other);
    }
}

impl AddAssign for Rational {
    fn add_assign(&mut self, other: Rational) {
        *self = self.sum(&other);
    }
}

impl SubAssign<&Rational> for Rational {
    fn sub_assign(&mut self, other: &Rational) {
        *self = self.subtract(other);
    }
}

impl MulAssign<&Rational> for Rational {
    fn mul_assign(&mut self, other: &Rational) {
        *self = self.multiply(other);
    }
}

impl Sum for Rational {
    fn sum<I: Iterator<Item = Rational>>(terms: I) -> Rational {
        terms.fold(Rational::zero(), |total, term| total + term)
    }
}

impl Product for Rational {
    fn product<I: Iterator<Item = Rational>>(factors: I) -> Rational {
        factors.fold(Rational::one(), |total, factor| total * factor)
    }
}
