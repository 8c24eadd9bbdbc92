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
            Small(numerator, denominator) => {
                Self::from_wide(i128::from(*denominator), i128::from(*numerator))
            }
            Big(ratio) => Self::from_ratio(ratio.recip()),
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
            let (a, b) = (i128::from(*a), i128::from(*b));
            let (c, d) = (i128::from(*c), i128::from(*d));
            return Self::from_wide(a * d + c * b, b * d);
        }
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        Self::from_ratio(self.to_ratio() + other.to_ratio())
    }

    fn multiply(&self, other: &Self) -> Self {
        if let (Small(a, b), Small(c, d)) = (&self.0, &other.0) {
            if *a == 0 || *c == 0 {
                return Self::zero();
            }
            let left = gcd(a.unsigned_abs(), d.unsigned_abs()) as i128;
            let right = gcd(c.unsigned_abs(), b.unsigned_abs()) as i128;
            let numerator = (i128::from(*a) / left) * (i128::from(*c) / right);
            let denominator = (i128::from(*b) / right) * (i128::from(*d) / left);
            if let (Ok(numerator), Ok(denominator)) =
                (i64::try_from(numerator), i64::try_from(denominator))
            {
                return Self(Small(numerator, denominator));
            }
            return Self::from_wide(numerator, denominator);
        }
        if self.is_one() {
            return other.clone();
        }
        if other.is_one() {
            return self.clone();
        }
        Self::from_ratio(self.to_ratio() * other.to_ratio())
    }

    fn divide(&self, divisor: &Self) -> Self {
        self.checked_div(divisor)
            .expect("division of a rational number by zero")
    }

    fn subtract(&self, other: &Self) -> Self {
        self.sum(&-other)
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
            Big(ratio) => Rational::from_ratio(-ratio.as_ref()),
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
