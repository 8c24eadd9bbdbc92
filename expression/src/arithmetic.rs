//! The operations that a formula needs, over whatever it is evaluated on.
//!
//! One [`Expression`](crate::Expression) is evaluated on exact polynomials ([`Ring`](crate::Ring)), on nodes of
//! straight-line code ([`Graph`](crate::Graph)), on polynomials of a curve parameter, or on numbers. The trait
//! [`Arithmetic`] is the context that carries these operations; its elements are plain values.

use thiserror::Error;

use crate::expression::{Binary, Function, Side};
use crate::rational::Rational;
use crate::special::Special;
use crate::table::Lookup;

/// Why an exact operation has no result.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum AlgebraError {
    /// A divisor is identically zero.
    #[error("division by an expression that is identically zero")]
    DivisionByZero,
    /// A function at an argument where it has no finite value, such as `ln(0)`.
    #[error("`{function}` of {argument} has no finite value")]
    OutsideDomain {
        /// The function's name.
        function: &'static str,
        /// The argument, as text.
        argument: String,
    },
    /// An exponent that is neither rational nor a function of the parameters alone.
    #[error("an exponent may contain numbers and parameters, not variables; write exp(b*ln(a))")]
    VariableExponent,
    /// An integer exponent past ±4096, whose expansion would not fit.
    #[error("the exponent {exponent} is too large: at most 4096 in absolute value")]
    ExponentTooLarge {
        /// The exponent, as text.
        exponent: String,
    },
    /// A power of a number with more binary digits than [`MOST_BITS`].
    #[error("a number of a formula has more than {MOST_BITS} binary digits; write a smaller power")]
    NumberTooLong,
    /// A product of more factors than [`MOST_FACTORS`].
    #[error(
        "a product of a formula has more than {MOST_FACTORS} factors; write powers such as q^9"
    )]
    TooManyFactors,
    /// More operations than straight-line code may have.
    #[error("its code has more than {most} operations")]
    CodeTooLong {
        /// The greatest number.
        most: usize,
    },
    /// A power beyond what expanded sums hold, built up by products.
    #[error(
        "a product's power grows past 32767 when sums are expanded; write such a power with exp and ln"
    )]
    ExpandedExponent,
    /// More products of terms than a ring may form.
    #[error("its expansion takes too many products of terms")]
    ExpansionTooLong,
    /// Code that no series is formed of: step sizes, and functions that a crate evaluates itself.
    #[error("code of step sizes or of a crate's own functions has no series")]
    NoSeries,
    /// More derivatives of a special function than are counted.
    #[error("`{function}` has no derivatives beyond the 255th")]
    DerivativeTooHigh {
        /// The function's name.
        function: &'static str,
    },
    /// A function of a curve parameter that is not constant along the curve.
    #[error("`{function}` of a non-constant polynomial is not a polynomial")]
    NotPolynomial {
        /// The function's name.
        function: &'static str,
    },
}

/// The most binary digits of a power of a number: sixty times those that doubles tell apart.
pub const MOST_BITS: u64 = 1 << 16;

/// The most factors of a product: what is made of one nests as deep.
pub const MOST_FACTORS: usize = 4096;

/// A commutative algebra over ℚ with the elementary functions of a scene's formulas.
pub trait Arithmetic {
    /// An element of the algebra.
    type Element: Clone + std::fmt::Debug;

    /// The rational number `value`.
    fn constant(&mut self, value: &Rational) -> Self::Element;
    /// π.
    fn pi(&mut self) -> Self::Element;
    /// The parameter with this index.
    fn parameter(&mut self, index: usize) -> Self::Element;
    /// Whether the element is recognized as zero: exact for normal forms, structural for code.
    fn is_zero(&self, element: &Self::Element) -> bool;
    /// The limit that was reached, so that results are void.
    fn refusal(&self) -> Option<&AlgebraError> {
        None
    }
    /// The element as a rational number, if it is one.
    fn as_rational(&self, element: &Self::Element) -> Option<Rational>;
    /// Whether sums are expanded, so that it is one how a sum of sums is grouped.
    fn is_expanded(&self) -> bool {
        false
    }
    /// Σ cᵢ eᵢ.
    fn combine(&mut self, terms: &[(Rational, Self::Element)]) -> Self::Element;
    /// a·b.
    fn multiply(&mut self, a: &Self::Element, b: &Self::Element) -> Self::Element;
    /// a·b, where factors of a that stand below in terms of b, or the reverse, cancel: the same value wherever a·b has one,
    /// and its limit where it is 0·∞. Normal forms cancel in any product.
    fn multiply_reduced(&mut self, a: &Self::Element, b: &Self::Element) -> Self::Element {
        self.multiply(a, b)
    }
    /// Σ cᵢ aᵢ bᵢ.
    fn sum_of_products(
        &mut self,
        products: &[(Rational, &Self::Element, &Self::Element)],
    ) -> Self::Element {
        let products = products.iter();
        let sum: Vec<_> = products
            .map(|(c, a, b)| (c.clone(), self.multiply(a, b)))
            .collect();
        self.combine(&sum)
    }
    /// a/b.
    ///
    /// # Errors
    /// [`AlgebraError::DivisionByZero`] when `b` is recognized as zero.
    fn divide(
        &mut self,
        a: &Self::Element,
        b: &Self::Element,
    ) -> Result<Self::Element, AlgebraError>;
    /// a^b for an exponent that is not a constant integer.
    ///
    /// # Errors
    /// [`AlgebraError::VariableExponent`] when `b` depends on variables.
    fn power(
        &mut self,
        a: &Self::Element,
        b: &Self::Element,
    ) -> Result<Self::Element, AlgebraError>;
    /// f(a).
    ///
    /// # Errors
    /// [`AlgebraError::OutsideDomain`] for a constant outside the domain of `function`.
    fn apply(
        &mut self,
        function: Function,
        a: &Self::Element,
    ) -> Result<Self::Element, AlgebraError>;
    /// f(a, b).
    ///
    /// # Errors
    /// [`AlgebraError::OutsideDomain`] for constants outside the domain of `function`.
    fn apply_two(
        &mut self,
        function: Binary,
        a: &Self::Element,
        b: &Self::Element,
    ) -> Result<Self::Element, AlgebraError>;
    /// A table, or one of its derivatives, at a point.
    ///
    /// # Errors
    /// [`AlgebraError`] where the algebra has no such element.
    fn look_up(
        &mut self,
        lookup: Lookup,
        point: &[Self::Element],
    ) -> Result<Self::Element, AlgebraError>;
    /// v where c is of this side of 0, 0 elsewhere, whatever v is there.
    ///
    /// # Errors
    /// [`AlgebraError`] where c is no number on every state and the algebra has no such element.
    fn kept(
        &mut self,
        side: Side,
        c: &Self::Element,
        v: &Self::Element,
    ) -> Result<Self::Element, AlgebraError>;
    /// Σ cᵢ eᵢ + Σ cⱼ aⱼ bⱼ: a coefficient of a product of series.
    fn combine_products(
        &mut self,
        terms: &[(Rational, Self::Element)],
        products: &[(Rational, &Self::Element, &Self::Element)],
    ) -> Self::Element {
        let mut sum = terms.to_vec();
        if self.is_expanded() {
            sum.push((Rational::one(), self.sum_of_products(products)));
        } else {
            for (c, a, b) in products {
                sum.push((c.clone(), self.multiply(a, b)));
            }
        }
        self.combine(&sum)
    }
    /// 0.
    fn zero(&mut self) -> Self::Element {
        self.constant(&Rational::zero())
    }
    /// 1.
    fn one(&mut self) -> Self::Element {
        self.constant(&Rational::one())
    }
    /// a + b.
    fn add(&mut self, a: &Self::Element, b: &Self::Element) -> Self::Element {
        self.combine(&[(Rational::one(), a.clone()), (Rational::one(), b.clone())])
    }
    /// a − b.
    fn subtract(&mut self, a: &Self::Element, b: &Self::Element) -> Self::Element {
        self.combine(&[(Rational::one(), a.clone()), (-Rational::one(), b.clone())])
    }
    /// c·a.
    fn scale(&mut self, c: &Rational, a: &Self::Element) -> Self::Element {
        self.combine(&[(c.clone(), a.clone())])
    }
    /// −a.
    fn negate(&mut self, a: &Self::Element) -> Self::Element {
        self.scale(&-Rational::one(), a)
    }
    /// aⁿ by repeated squaring.
    ///
    /// # Errors
    /// [`AlgebraError::DivisionByZero`] for a negative power of zero,
    /// [`AlgebraError::ExponentTooLarge`] past ±4096, [`AlgebraError::NumberTooLong`] for a number's
    /// power past [`MOST_BITS`].
    fn integer_power(
        &mut self,
        a: &Self::Element,
        exponent: i64,
    ) -> Result<Self::Element, AlgebraError> {
        if exponent.abs() > 4096 {
            return Err(AlgebraError::ExponentTooLarge {
                exponent: exponent.to_string(),
            });
        }
        let number = self.as_rational(a);
        if number.is_some_and(|r| r.bits() > 1 && r.bits() * exponent.unsigned_abs() > MOST_BITS) {
            return Err(AlgebraError::NumberTooLong);
        }
        let mut result = None;
        let mut square = a.clone();
        let mut remaining = exponent.unsigned_abs();
        while remaining > 0 {
            if remaining & 1 == 1 {
                result = Some(match result {
                    None => square.clone(),
                    Some(r) => self.multiply(&r, &square),
                });
            }
            remaining >>= 1;
            if remaining > 0 {
                square = self.multiply(&square, &square);
            }
        }
        if let Some(refusal) = self.refusal() {
            return Err(refusal.clone());
        }
        let one = self.one();
        let result = result.unwrap_or_else(|| one.clone());
        if exponent < 0 {
            self.divide(&one, &result)
        } else {
            Ok(result)
        }
    }
}

/// f(x) of a number x where that is a whole number by definition.
///
/// # Errors
/// [`AlgebraError::OutsideDomain`] for a number outside the domain.
pub(crate) fn simple_value(
    function: Function,
    x: &Rational,
) -> Result<Option<Rational>, AlgebraError> {
    let outside = || {
        Err(AlgebraError::OutsideDomain {
            function: function.name(),
            argument: x.to_string(),
        })
    };
    let zero_or_one = |is_one: bool| {
        Ok(Some(match is_one {
            true => Rational::one(),
            false => Rational::zero(),
        }))
    };
    match function {
        Function::Ln | Function::Log10 | Function::Log2 => match x {
            x if x.is_one() => zero_or_one(false),
            x if x.is_zero() => outside(),
            _ => Ok(None),
        },
        Function::Abs => Ok(Some(x.abs())),
        Function::Sign => Ok(Some(Rational::from_integer(x.signum().into()))),
        Function::Floor => Ok(Some(x.floor())),
        Function::Acos | Function::Acosh if x.is_one() => zero_or_one(false),
        Function::Gamma if x.is_one() => zero_or_one(true),
        Function::Gamma if x.is_zero() => outside(),
        Function::Special(Special::LnGamma, 0) if x.is_zero() => outside(),
        Function::Special(Special::J0, 0)
        | Function::Exp
        | Function::Cos
        | Function::Cosh
        | Function::Erfc
            if x.is_zero() =>
        {
            zero_or_one(true)
        }
        Function::Acos | Function::Acosh | Function::Gamma => Ok(None),
        Function::Special(Special::J1, 0) if x.is_zero() => zero_or_one(false),
        Function::Special(..) | Function::Erfc => Ok(None),
        Function::Exp | Function::Cos | Function::Cosh => Ok(None),
        _ if x.is_zero() => zero_or_one(false),
        Function::Sqrt if x.is_one() => zero_or_one(true),
        _ => Ok(None),
    }
}

/// f(a, b) of numbers where that is a number by definition.
///
/// # Errors
/// [`AlgebraError::OutsideDomain`] for a remainder by 0.
pub(crate) fn simple_value_of_two(
    function: Binary,
    a: &Rational,
    b: &Rational,
) -> Result<Option<Rational>, AlgebraError> {
    match function {
        Binary::Atan2 if a.is_zero() && !b.is_negative() => Ok(Some(Rational::zero())),
        Binary::Atan2 => Ok(None),
        Binary::Mod => match a.checked_div(b) {
            Some(quotient) => Ok(Some(a - &(b * &quotient.floor()))),
            None => Err(AlgebraError::OutsideDomain {
                function: function.name(),
                argument: format!("{a}, 0"),
            }),
        },
    }
}

/// ∂f/∂a of f(a, b) for `by` 0, ∂f/∂b for 1.
///
/// # Errors
/// Those of [`Arithmetic::divide`] and [`Arithmetic::apply`].
pub fn binary_derivative<A: Arithmetic>(
    arithmetic: &mut A,
    function: Binary,
    [a, b]: [&A::Element; 2],
    by: usize,
) -> Result<A::Element, AlgebraError> {
    match (function, by) {
        (Binary::Atan2, _) => {
            let one = Rational::one();
            let radius = arithmetic.sum_of_products(&[(one.clone(), a, a), (one, b, b)]);
            match by {
                0 => arithmetic.divide(b, &radius),
                _ => {
                    let opposite = arithmetic.negate(a);
                    arithmetic.divide(&opposite, &radius)
                }
            }
        }
        (Binary::Mod, 0) => Ok(arithmetic.one()),
        (Binary::Mod, _) => {
            let quotient = arithmetic.divide(a, b)?;
            let whole = arithmetic.apply(Function::Floor, &quotient)?;
            Ok(arithmetic.negate(&whole))
        }
    }
}

/// f′(u), given u and g = f(u): the one table of derivatives.
///
/// # Errors
/// Those of [`Arithmetic::divide`] and [`Arithmetic::apply`].
pub fn function_derivative<A: Arithmetic>(
    arithmetic: &mut A,
    function: Function,
    u: &A::Element,
    g: &A::Element,
) -> Result<A::Element, AlgebraError> {
    let one = arithmetic.one();
    let minus = -Rational::one();
    match function {
        Function::Exp => Ok(g.clone()),
        Function::Ln => arithmetic.divide(&one, u),
        Function::Sqrt => {
            let twice = arithmetic.scale(&Rational::from_integer(2), g);
            arithmetic.divide(&one, &twice)
        }
        Function::Sin => arithmetic.apply(Function::Cos, u),
        Function::Cos => {
            let sine = arithmetic.apply(Function::Sin, u)?;
            Ok(arithmetic.negate(&sine))
        }
        Function::Sinh => arithmetic.apply(Function::Cosh, u),
        Function::Cosh => arithmetic.apply(Function::Sinh, u),
        Function::Tan | Function::Tanh => {
            let square = arithmetic.multiply(g, g);
            let sign = if function == Function::Tan {
                Rational::one()
            } else {
                minus
            };
            Ok(arithmetic.combine(&[(Rational::one(), one), (sign, square)]))
        }
        Function::Asin | Function::Acos | Function::Asinh | Function::Acosh => {
            let square = arithmetic.multiply(u, u);
            let (constant, quadratic) = match function {
                Function::Asinh => (Rational::one(), Rational::one()),
                Function::Acosh => (minus.clone(), Rational::one()),
                _ => (Rational::one(), minus.clone()),
            };
            let inside = arithmetic.combine(&[(constant, one.clone()), (quadratic, square)]);
            let root = arithmetic.apply(Function::Sqrt, &inside)?;
            let inverse = arithmetic.divide(&one, &root)?;
            Ok(if function == Function::Acos {
                arithmetic.negate(&inverse)
            } else {
                inverse
            })
        }
        Function::Atan | Function::Atanh => {
            let square = arithmetic.multiply(u, u);
            let sign = if function == Function::Atan {
                Rational::one()
            } else {
                minus
            };
            let below = arithmetic.combine(&[(Rational::one(), one.clone()), (sign, square)]);
            arithmetic.divide(&one, &below)
        }
        Function::Abs => arithmetic.apply(Function::Sign, u),
        Function::Sign | Function::Floor => Ok(arithmetic.zero()),
        // ±2/√π e^{−u²}.
        Function::Erf | Function::Erfc => {
            let pi = arithmetic.pi();
            let root = arithmetic.apply(Function::Sqrt, &pi)?;
            let square = arithmetic.multiply(u, u);
            let square = arithmetic.negate(&square);
            let bell = arithmetic.apply(Function::Exp, &square)?;
            let sign = if function == Function::Erf { 2 } else { -2 };
            let bell = arithmetic.scale(&Rational::from_integer(sign), &bell);
            arithmetic.divide(&bell, &root)
        }
        // Γ ψ.
        Function::Gamma => {
            let digamma = arithmetic.apply(Function::Special(Special::LnGamma, 1), u)?;
            Ok(arithmetic.multiply(g, &digamma))
        }
        Function::Log10 | Function::Log2 => {
            let base = if function == Function::Log10 { 10 } else { 2 };
            let base = arithmetic.constant(&Rational::from_integer(base));
            let logarithm = arithmetic.apply(Function::Ln, &base)?;
            let below = arithmetic.multiply(u, &logarithm);
            arithmetic.divide(&one, &below)
        }
        Function::Special(Special::J0, 0) => {
            let other = arithmetic.apply(Function::Special(Special::J1, 0), u)?;
            Ok(arithmetic.negate(&other))
        }
        Function::Special(special, order) => {
            let next = order
                .checked_add(1)
                .ok_or(AlgebraError::DerivativeTooHigh {
                    function: special.name(),
                })?;
            arithmetic.apply(Function::Special(special, next), u)
        }
    }
}
