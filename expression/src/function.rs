//! The functions that formulas apply, and the sides of a seam.

use std::fmt;

use crate::analytic::{FunctionPair, Member};
use crate::elementary;
use crate::pairs::SINE_AND_COSINE;
use crate::rational::Rational;
use crate::special::Special;

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    /// The exponential function.
    Exp,
    /// The natural logarithm.
    Ln,
    /// The square root.
    Sqrt,
    /// The sine.
    Sin,
    /// The cosine.
    Cos,
    /// The tangent.
    Tan,
    /// The inverse sine.
    Asin,
    /// The inverse cosine.
    Acos,
    /// The inverse tangent.
    Atan,
    /// The hyperbolic sine.
    Sinh,
    /// The hyperbolic cosine.
    Cosh,
    /// The hyperbolic tangent.
    Tanh,
    /// The inverse hyperbolic sine.
    Asinh,
    /// The inverse hyperbolic cosine.
    Acosh,
    /// The inverse hyperbolic tangent.
    Atanh,
    /// The magnitude |x|.
    Abs,
    /// The sign: −1, 0 or 1.
    Sign,
    /// The largest integer that is not above x.
    Floor,
    /// The error function 2/√π ∫₀ˣ e^{−t²} dt.
    Erf,
    /// The complement 1 − erf x.
    Erfc,
    /// The gamma function.
    Gamma,
    /// The logarithm of base 10.
    Log10,
    /// The logarithm of base 2.
    Log2,
    /// A derivative of this order of a special function, 0 for the function itself.
    Special(Special, u8),
}

impl Function {
    /// Every function of formulas.
    pub const ALL: [Function; 28] = [
        Function::Exp,
        Function::Ln,
        Function::Sqrt,
        Function::Sin,
        Function::Cos,
        Function::Tan,
        Function::Asin,
        Function::Acos,
        Function::Atan,
        Function::Sinh,
        Function::Cosh,
        Function::Tanh,
        Function::Asinh,
        Function::Acosh,
        Function::Atanh,
        Function::Abs,
        Function::Sign,
        Function::Floor,
        Function::Erf,
        Function::Erfc,
        Function::Gamma,
        Function::Log10,
        Function::Log2,
        Function::Special(Special::LnGamma, 0),
        Function::Special(Special::J0, 0),
        Function::Special(Special::J1, 0),
        Function::Special(Special::EllipticK, 0),
        Function::Special(Special::EllipticE, 0),
    ];

    /// The names, in the order of [`Function::ALL`].
    pub const NAMES: [&'static str; 28] = [
        "exp", "ln", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
        "asinh", "acosh", "atanh", "abs", "sign", "floor", "erf", "erfc", "gamma", "log10", "log2",
        "lgamma", "j0", "j1", "ellipk", "ellipe",
    ];

    /// So many of these functions come first whose names stand for nothing else.
    pub(crate) const RESERVED: usize = 15;

    /// The name formulas use.
    pub fn name(self) -> &'static str {
        let plain = match self {
            Function::Special(special, _) => return special.name(),
            plain => plain,
        };
        let position = Self::ALL.iter().position(|known| *known == plain);
        position.map_or("", |at| Self::NAMES[at])
    }

    /// The function of an argument as it is written; a derivative has its order behind the argument.
    pub fn called(self, argument: &str) -> String {
        match self {
            Function::Special(special, order) if order > 0 => {
                format!("{}({argument}, {order})", special.name())
            }
            plain => format!("{}({argument})", plain.name()),
        }
    }

    /// The function of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let position = Self::NAMES.iter().position(|known| *known == name)?;
        Some(Self::ALL[position])
    }

    /// The value at `x`, computed by `libm`: the same bits on every machine. Outside the
    /// function's domain it is NaN, at a pole infinite.
    pub fn apply(self, x: f64) -> f64 {
        match self {
            Function::Exp => libm::exp(x),
            Function::Ln => libm::log(x),
            Function::Sqrt => libm::sqrt(x),
            Function::Sin => libm::sin(x),
            Function::Cos => libm::cos(x),
            Function::Tan => libm::tan(x),
            Function::Asin => libm::asin(x),
            Function::Acos => libm::acos(x),
            Function::Atan => libm::atan(x),
            Function::Sinh => libm::sinh(x),
            Function::Cosh => libm::cosh(x),
            Function::Tanh => libm::tanh(x),
            Function::Asinh => libm::asinh(x),
            Function::Acosh => libm::acosh(x),
            Function::Atanh => libm::atanh(x),
            Function::Abs => x.abs(),
            Function::Sign => kept(Side::Above, x, 1.0) - kept(Side::Above, -x, 1.0),
            Function::Floor => libm::floor(x),
            Function::Erf => libm::erf(x),
            Function::Erfc => libm::erfc(x),
            Function::Gamma => libm::tgamma(x),
            Function::Log10 => libm::log10(x),
            Function::Log2 => libm::log2(x),
            Function::Special(special, order) => special.derivative(order.into(), x),
        }
    }

    /// Whether f(−x) is f(x), or −f(x) for every x; `None` where neither holds.
    pub(crate) fn parity(self) -> Option<Parity> {
        match self {
            Function::Cos | Function::Cosh | Function::Abs => Some(Parity::Even),
            Function::Sin
            | Function::Tan
            | Function::Asin
            | Function::Atan
            | Function::Sinh
            | Function::Tanh
            | Function::Asinh
            | Function::Atanh
            | Function::Sign
            | Function::Erf => Some(Parity::Odd),
            Function::Special(special @ (Special::J0 | Special::J1), order) => {
                let is_odd = (special == Special::J1) ^ (order % 2 == 1);
                Some(if is_odd { Parity::Odd } else { Parity::Even })
            }
            _ => None,
        }
    }

    /// Whether it is constant but for jumps: its derivative is 0.
    pub(crate) fn is_step(self) -> bool {
        matches!(self, Function::Sign | Function::Floor)
    }

    /// The pair of functions that it is a member of.
    pub(crate) fn pair(self) -> Option<(&'static FunctionPair, Member)> {
        match self {
            Function::Sin => Some((&SINE_AND_COSINE, Member::First)),
            Function::Cos => Some((&SINE_AND_COSINE, Member::Second)),
            _ => None,
        }
    }

    /// [`Function::apply`] to each number, to the same bits; many at once where the function has
    /// such a form.
    pub fn apply_lanes(self, values: &mut [f64]) {
        match self {
            Function::Exp => elementary::exp_lanes(values),
            Function::Ln => elementary::ln_lanes(values),
            Function::Sqrt => elementary::sqrt_lanes(values),
            Function::Sin => elementary::sin_lanes(values),
            Function::Cos => elementary::cos_lanes(values),
            Function::Tan => elementary::tan_lanes(values),
            Function::Atan => elementary::atan_lanes(values),
            _ => values.iter_mut().for_each(|x| *x = self.apply(*x)),
        }
    }
}

impl fmt::Display for Function {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Function::Special(special, order @ 1..) => {
                write!(formatter, "{}^({order})", special.name())
            }
            plain => formatter.write_str(plain.name()),
        }
    }
}

/// A function of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Binary {
    /// The angle of (x, y) in (−π, π], of y and x.
    Atan2,
    /// x − y⌊x/y⌋, of x and y: from 0 to y, y not included.
    Mod,
}

impl Binary {
    /// The functions, with the names that formulas use.
    pub const ALL: [(&'static str, Self); 2] = [("atan2", Self::Atan2), ("mod", Self::Mod)];

    /// The name that formulas use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Atan2 => "atan2",
            Self::Mod => "mod",
        }
    }

    /// The function of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = Self::ALL.into_iter().find(|(known, _)| *known == name);
        found.map(|(_, function)| function)
    }

    /// The value, to the same bits on every machine: `atan2` by `libm`, with C's values at zeros and infinities, `mod`
    /// from the exact remainder of `libm::fmod`.
    pub fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Atan2 => libm::atan2(a, b),
            Self::Mod => {
                // Of the sign of a.
                let rest = libm::fmod(a, b);
                let is_opposite = rest != 0.0 && rest.is_sign_negative() != b.is_sign_negative();
                let rest = if is_opposite { rest + b } else { rest };
                // Rounded to a whole period, it is none.
                if rest == b && b.is_finite() {
                    0.0
                } else {
                    rest
                }
            }
        }
    }

    /// Whether its derivatives jump where its value does. Those of an angle are smooth across its cut.
    pub(crate) fn has_seams(self) -> bool {
        self == Self::Mod
    }
}

/// How a function changes with the sign of its argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parity {
    /// f(−x) = f(x).
    Even,
    /// f(−x) = −f(x).
    Odd,
}

/// The arguments of one side of a seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// c > 0.
    Above,
    /// c ≤ 0.
    Below,
}

impl Side {
    /// Whether a number is of it.
    pub fn has(self, c: &Rational) -> bool {
        let is_above = !c.is_zero() && !c.is_negative();
        is_above == (self == Self::Above)
    }
}

/// v where c is of this side, 0 elsewhere, whatever v is there; NaN where c is.
pub(crate) fn kept(side: Side, c: f64, v: f64) -> f64 {
    let is_kept = (c > 0.0) == (side == Side::Above);
    // 0, or no number.
    let nothing = if c.is_nan() { f64::NAN } else { 0.0 };
    (if is_kept { v } else { 0.0 }) + nothing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_functions_correspond() {
        for (function, name) in Function::ALL.into_iter().zip(Function::NAMES) {
            assert_eq!(function.name(), name);
            assert_eq!(Function::from_name(name), Some(function));
        }
        assert_eq!(Function::from_name("log"), None);
    }
}
