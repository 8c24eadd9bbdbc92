//! Numbers beyond the range of doubles: products of factorials and powers on the way to a number within it.

use std::ops::{Add, Mul, Neg, Sub};

/// m·2ᵏ with ½ ≤ |m| < 1; m is 0, infinite or no number as of a double.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaled {
    mantissa: f64,
    exponent: i32,
}

impl Scaled {
    pub(super) const ZERO: Self = Self {
        mantissa: 0.0,
        exponent: 0,
    };

    /// A number.
    pub(super) fn new(value: f64) -> Self {
        Self::at(value, 0)
    }

    /// value·2ᵏ for k = `exponent`.
    fn at(value: f64, exponent: i32) -> Self {
        if value == 0.0 || !value.is_finite() {
            return Self {
                mantissa: value,
                exponent: 0,
            };
        }
        let (mantissa, own) = libm::frexp(value);
        Self {
            mantissa,
            exponent: own + exponent,
        }
    }

    /// xⁿ of x > 0.
    pub(super) fn power(x: f64, n: i32) -> Self {
        let Self { mantissa, exponent } = Self::new(x);
        Self::at(libm::pow(mantissa, f64::from(n)), exponent * n)
    }

    /// n!, within a unit in the last place: what the products round off is carried along.
    pub(super) fn factorial(n: u32) -> Self {
        let (mut product, mut rest, mut exponent) = (1.0, 0.0, 0);
        for k in 1..=n {
            let k = f64::from(k);
            let next = product * k;
            rest = rest * k + libm::fma(product, k, -next);
            let (mantissa, own) = libm::frexp(next);
            product = mantissa;
            rest = libm::ldexp(rest, -own);
            exponent += own;
        }
        Self::at(product + rest, exponent)
    }

    /// The number as a double: infinite or 0 where it is outside of their range.
    pub(super) fn value(self) -> f64 {
        libm::ldexp(self.mantissa, self.exponent)
    }
}

impl Neg for Scaled {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            mantissa: -self.mantissa,
            ..self
        }
    }
}

impl Mul for Scaled {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::at(
            self.mantissa * other.mantissa,
            self.exponent + other.exponent,
        )
    }
}

impl Add for Scaled {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        if self.mantissa == 0.0 {
            return other;
        }
        if other.mantissa == 0.0 {
            return self;
        }
        let exponent = self.exponent.max(other.exponent);
        let [a, b] = [self, other].map(|part| libm::ldexp(part.mantissa, part.exponent - exponent));
        Self::at(a + b, exponent)
    }
}

impl Sub for Scaled {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}
