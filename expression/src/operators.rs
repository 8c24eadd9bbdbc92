//! Formulas written in Rust: `x * y + x.sin()`.

use std::iter;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::expression::{Expression, Function};
use crate::rational::Rational;
use crate::special::Special;

/// A variable or a parameter of a system, by its index: what formulas in Rust are written with.
///
/// Sums, products, quotients and functions of quantities, formulas and numbers are formulas:
///
/// ```
/// use leafwise_expression::Quantity;
///
/// let (x, y, a) = (Quantity::Variable(0), Quantity::Variable(1), Quantity::Parameter(0));
/// let formula = (x * x + y * y) / 2 - a * x.cos() + 0.1 * y.pow(3);
/// let names = ["x", "y"].map(str::to_owned);
/// assert_eq!(
///     formula.written(&names, &["a".to_owned()]),
///     "(x*x + y*y)/2 - a*cos(x) + 0.1*y^3"
/// );
/// assert_eq!(formula.evaluate(&[0.0, 2.0], &[3.0]), 2.0 - 3.0 + 0.8);
/// ```
///
/// A number is exact. An `f64` stands for the shortest decimal that rounds to it, as it is printed and as a scene
/// reads it, so that 0.1 is 1/10. NaN and the infinities are 0/0, 1/0 and −1/0, which every system refuses as a
/// division by zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// The state variable of this index.
    Variable(usize),
    /// The parameter of this index.
    Parameter(usize),
}

impl From<Quantity> for Expression {
    fn from(quantity: Quantity) -> Self {
        match quantity {
            Quantity::Variable(index) => Self::Variable(index),
            Quantity::Parameter(index) => Self::Parameter(index),
        }
    }
}

impl From<&Expression> for Expression {
    fn from(formula: &Expression) -> Self {
        formula.clone()
    }
}

impl From<Rational> for Expression {
    fn from(number: Rational) -> Self {
        Self::Constant(number)
    }
}

impl From<i32> for Expression {
    fn from(number: i32) -> Self {
        Self::Constant(Rational::from_integer(number.into()))
    }
}

impl From<f64> for Expression {
    fn from(number: f64) -> Self {
        // `{:e}` prints the shortest decimal, which parses unless it is NaN or infinite.
        let over_zero = |above: i32| quotient(above.into(), 0.into());
        Rational::parse_decimal(&format!("{number:e}")).map_or_else(
            |_| match number {
                f64::INFINITY => over_zero(1),
                f64::NEG_INFINITY => over_zero(-1),
                _ => over_zero(0),
            },
            Self::Constant,
        )
    }
}

fn sum(left: Expression, right: Expression) -> Expression {
    match left {
        Expression::Sum(mut terms) => {
            terms.push(right);
            Expression::Sum(terms)
        }
        left => Expression::Sum(vec![left, right]),
    }
}

fn difference(left: Expression, right: Expression) -> Expression {
    sum(left, negated(right))
}

fn product(left: Expression, right: Expression) -> Expression {
    match left {
        Expression::Product(mut factors) => {
            factors.push(right);
            Expression::Product(factors)
        }
        left => Expression::Product(vec![left, right]),
    }
}

/// −a; of a number the number itself.
pub(crate) fn negated(operand: Expression) -> Expression {
    match operand {
        Expression::Constant(number) => Expression::Constant(-number),
        operand => Expression::Negate(Box::new(operand)),
    }
}

/// a / b; of numbers the number itself, unless b is 0.
pub(crate) fn quotient(numerator: Expression, denominator: Expression) -> Expression {
    if let (Expression::Constant(numerator), Expression::Constant(denominator)) =
        (&numerator, &denominator)
        && let Some(value) = numerator.checked_div(denominator)
    {
        return Expression::Constant(value);
    }
    Expression::Quotient(Box::new(numerator), Box::new(denominator))
}

macro_rules! operator {
    ($trait:ident, $method:ident, $combine:ident, [$($left:ty),*], [$($number:ty),*]) => {
        $(
            impl<R: Into<Expression>> $trait<R> for $left {
                type Output = Expression;

                fn $method(self, right: R) -> Expression {
                    $combine(self.into(), right.into())
                }
            }
        )*
        $(
            operator!($trait, $method, $combine, $number, Quantity);
            operator!($trait, $method, $combine, $number, Expression);
            operator!($trait, $method, $combine, $number, &Expression);
        )*
    };
    ($trait:ident, $method:ident, $combine:ident, $left:ty, $right:ty) => {
        impl $trait<$right> for $left {
            type Output = Expression;

            fn $method(self, right: $right) -> Expression {
                $combine(self.into(), right.into())
            }
        }
    };
}

operator!(
    Add,
    add,
    sum,
    [Quantity, Expression, &Expression],
    [i32, f64]
);
operator!(
    Sub,
    sub,
    difference,
    [Quantity, Expression, &Expression],
    [i32, f64]
);
operator!(
    Mul,
    mul,
    product,
    [Quantity, Expression, &Expression],
    [i32, f64]
);
operator!(
    Div,
    div,
    quotient,
    [Quantity, Expression, &Expression],
    [i32, f64]
);

macro_rules! negation {
    ($($operand:ty),*) => {
        $(
            impl Neg for $operand {
                type Output = Expression;

                fn neg(self) -> Expression {
                    negated(self.into())
                }
            }
        )*
    };
}

negation!(Quantity, Expression, &Expression);

/// The sum of the terms, 0 without any.
impl iter::Sum for Expression {
    fn sum<I: Iterator<Item = Expression>>(terms: I) -> Self {
        Self::Sum(terms.collect())
    }
}

macro_rules! functions {
    ($($name:ident ($function:expr) $text:literal),*) => {
        impl Quantity {
            /// The power with this exponent, a number or a formula of parameters.
            pub fn pow(self, exponent: impl Into<Expression>) -> Expression {
                Expression::from(self).pow(exponent)
            }

            $(
                #[doc = concat!("The ", $text, ".")]
                pub fn $name(self) -> Expression {
                    Expression::from(self).$name()
                }
            )*
        }

        impl Expression {
            /// The power with this exponent, a number or a formula of parameters.
            pub fn pow(&self, exponent: impl Into<Expression>) -> Expression {
                Expression::Power(Box::new(self.clone()), Box::new(exponent.into()))
            }

            $(
                #[doc = concat!("The ", $text, ".")]
                pub fn $name(&self) -> Expression {
                    Expression::Apply($function, Box::new(self.clone()))
                }
            )*
        }
    };
}

functions! {
    exp (Function::Exp) "exponential function",
    ln (Function::Ln) "natural logarithm",
    sqrt (Function::Sqrt) "square root",
    sin (Function::Sin) "sine",
    cos (Function::Cos) "cosine",
    tan (Function::Tan) "tangent",
    asin (Function::Asin) "inverse sine",
    acos (Function::Acos) "inverse cosine",
    atan (Function::Atan) "inverse tangent",
    sinh (Function::Sinh) "hyperbolic sine",
    cosh (Function::Cosh) "hyperbolic cosine",
    tanh (Function::Tanh) "hyperbolic tangent",
    asinh (Function::Asinh) "inverse hyperbolic sine",
    acosh (Function::Acosh) "inverse hyperbolic cosine",
    atanh (Function::Atanh) "inverse hyperbolic tangent",
    abs (Function::Abs) "magnitude",
    sign (Function::Sign) "sign, −1, 0 or 1",
    floor (Function::Floor) "largest integer that is not above it",
    erf (Function::Erf) "error function",
    erfc (Function::Erfc) "complement of the error function",
    gamma (Function::Gamma) "gamma function",
    log10 (Function::Log10) "logarithm of base 10",
    log2 (Function::Log2) "logarithm of base 2",
    lgamma (Function::Special(Special::LnGamma, 0)) "logarithm of the magnitude of the gamma function",
    j0 (Function::Special(Special::J0, 0)) "Bessel function J₀",
    j1 (Function::Special(Special::J1, 0)) "Bessel function J₁",
    ellipk (Function::Special(Special::EllipticK, 0)) "complete elliptic integral K of the parameter m",
    ellipe (Function::Special(Special::EllipticE, 0)) "complete elliptic integral E of the parameter m"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::{Formula, Scope};

    fn parsed(text: &str) -> Expression {
        let scope = Scope::new()
            .with_variables(&["x", "y"])
            .with_parameters(&["a"]);
        let formula = Formula::parse(text).expect("a formula");
        let resolved = formula.resolve(&scope, None).expect("known names");
        resolved.expect("no boundary")
    }

    /// The tree, and with it every bit of a run, is that of the same text.
    #[test]
    fn a_formula_in_rust_is_the_same_as_in_a_scene() {
        let (x, y, a) = (
            Quantity::Variable(0),
            Quantity::Variable(1),
            Quantity::Parameter(0),
        );
        let energy = (x * x + y.pow(2)) / 2;
        for (written, text) in [
            (x * y + x.sin(), "x*y + sin(x)"),
            (x - y - 2 + a, "x - y - 2 + a"),
            (2 * x * y / a, "2*x*y/a"),
            (-x * y - -y, "-x*y - -y"),
            (0.1 * x - 2.5e-3 / y, "0.1*x - 0.0025/y"),
            (&energy - a * &energy, "(x*x + y^2)/2 - a*((x*x + y^2)/2)"),
            (
                x.pow(a) + energy.sqrt().ln(),
                "x^a + ln(sqrt((x*x + y^2)/2))",
            ),
            (x.pow(-0.5) + 1e21, "x^-0.5 + 1e21"),
            (1 + x.exp() * 3, "1 + exp(x)*3"),
        ] {
            assert_eq!(written, parsed(text), "{text}");
        }
        let sum: Expression = [x, y].into_iter().map(Expression::from).sum();
        assert_eq!(sum, parsed("x + y"));
    }

    #[test]
    fn every_function_is_its_own() {
        let x = Quantity::Variable(0);
        let made = [
            x.exp(),
            x.ln(),
            x.sqrt(),
            x.sin(),
            x.cos(),
            x.tan(),
            x.asin(),
            x.acos(),
            x.atan(),
            x.sinh(),
            x.cosh(),
            x.tanh(),
            x.asinh(),
            x.acosh(),
            x.atanh(),
            x.abs(),
            x.sign(),
            x.floor(),
            x.erf(),
            x.erfc(),
            x.gamma(),
            x.log10(),
            x.log2(),
            x.lgamma(),
            x.j0(),
            x.j1(),
            x.ellipk(),
            x.ellipe(),
        ];
        assert_eq!(made.len(), Function::NAMES.len());
        for (made, name) in made.into_iter().zip(Function::NAMES) {
            assert_eq!(made, parsed(&format!("{name}(x)")));
        }
    }

    #[test]
    fn numbers_that_are_none_are_divisions_by_zero() {
        let zero = || Box::new(Expression::from(0));
        for (number, above) in [(f64::NAN, 0), (f64::INFINITY, 1), (f64::NEG_INFINITY, -1)] {
            let expected = Expression::Quotient(Box::new(above.into()), zero());
            assert_eq!(Expression::from(number), expected);
        }
        let least = Expression::from(f64::MIN_POSITIVE / 3.0);
        assert_eq!(least.evaluate(&[], &[]), f64::MIN_POSITIVE / 3.0);
        assert_eq!(Expression::from(f64::MAX).evaluate(&[], &[]), f64::MAX);
    }
}
