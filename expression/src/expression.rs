//! Resolved formulas: trees over numbered variables and parameters with exact constants.

use std::collections::BTreeSet;
use std::fmt;

use crate::analytic::{FunctionPair, Member};
use crate::elementary;
use crate::pairs::SINE_AND_COSINE;
use crate::rational::Rational;
use crate::shared::{Known, Shared};
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

/// v where c is of this side, 0 elsewhere; NaN where c is not finite.
pub(crate) fn kept(side: Side, c: f64, v: f64) -> f64 {
    let is_kept = (c > 0.0) == (side == Side::Above);
    // 0, or no number.
    let nothing = if c.is_finite() { 0.0 } else { f64::NAN };
    (if is_kept { v } else { 0.0 }) + nothing
}

/// A formula whose names are resolved: variables and parameters by their index.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// An exact number.
    Constant(Rational),
    /// The number π.
    Pi,
    /// The state variable of this index.
    Variable(usize),
    /// The parameter of this index.
    Parameter(usize),
    /// The sum of the terms; 0 without any.
    Sum(Vec<Expression>),
    /// The product of the factors; 1 without any.
    Product(Vec<Expression>),
    /// −a.
    Negate(Box<Expression>),
    /// a / b.
    Quotient(Box<Expression>, Box<Expression>),
    /// a^b.
    Power(Box<Expression>, Box<Expression>),
    /// f(a).
    Apply(Function, Box<Expression>),
    /// a where c > 0, b where c ≤ 0, of c, a and b.
    Where(Box<[Expression; 3]>),
    /// A formula that stands elsewhere too.
    Shared(Shared<Expression>),
}

impl Expression {
    /// v where c is of this side, 0 elsewhere.
    pub(crate) fn kept(side: Side, c: Self, v: Self) -> Self {
        let zero = Self::Constant(Rational::zero());
        Self::Where(Box::new(match side {
            Side::Above => [c, v, zero],
            Side::Below => [c, zero, v],
        }))
    }

    /// The value in plain double arithmetic, terms and factors from left to right: a reference
    /// for the compiled kernels.
    ///
    /// A power with a constant integer exponent is formed by repeated squaring, any other by
    /// `libm::pow`. Outside a domain the value is NaN or infinite.
    ///
    /// # Panics
    /// When an index is outside `variables` or `parameters`.
    pub fn evaluate(&self, variables: &[f64], parameters: &[f64]) -> f64 {
        self.value(variables, parameters, &mut Known::default())
    }

    fn value(&self, variables: &[f64], parameters: &[f64], known: &mut Known<Self, f64>) -> f64 {
        let mut value = |part: &Expression| part.value(variables, parameters, known);
        match self {
            Expression::Constant(number) => number.to_f64(),
            Expression::Pi => std::f64::consts::PI,
            Expression::Variable(index) => variables[*index],
            Expression::Parameter(index) => parameters[*index],
            Expression::Sum(terms) => terms.iter().map(value).fold(0.0, |sum, term| sum + term),
            Expression::Product(factors) => factors.iter().map(value).product(),
            Expression::Negate(operand) => -value(operand),
            Expression::Quotient(numerator, denominator) => value(numerator) / value(denominator),
            Expression::Power(base, exponent) => match exponent.integer() {
                Some(exponent) => integer_power(value(base), exponent),
                None => libm::pow(value(base), value(exponent)),
            },
            Expression::Apply(function, argument) => function.apply(value(argument)),
            Expression::Where(parts) => {
                let [c, a, b] = parts.each_ref().map(value);
                kept(Side::Above, c, a) + kept(Side::Below, c, b)
            }
            Expression::Shared(shared) => known.get(shared).unwrap_or_else(|| {
                let value = shared.value(variables, parameters, known);
                known.insert(shared, value);
                value
            }),
        }
    }

    /// The indices of the variables that occur.
    pub fn variables(&self) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        self.visit(&mut |part| {
            if let Expression::Variable(index) = part {
                found.insert(*index);
            }
        });
        found
    }

    /// The indices of the parameters that occur.
    pub fn parameters(&self) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        self.visit(&mut |part| {
            if let Expression::Parameter(index) = part {
                found.insert(*index);
            }
        });
        found
    }

    /// The same formula with exact numbers in place of the parameters.
    ///
    /// # Panics
    /// When an index is outside `values`.
    pub fn with_parameters(&self, values: &[Rational]) -> Self {
        let value = |part: &Expression| match part {
            Expression::Parameter(index) => Expression::Constant(values[*index].clone()),
            other => other.clone(),
        };
        self.replaced(&value, &mut Known::default())
    }

    /// The same formula of other variables: `indices[i]` in the place of i.
    ///
    /// # Panics
    /// When an index is outside `indices`.
    pub fn with_variables(&self, indices: &[usize]) -> Self {
        let other = |part: &Expression| match part {
            Expression::Variable(index) => Expression::Variable(indices[*index]),
            other => other.clone(),
        };
        self.replaced(&other, &mut Known::default())
    }

    /// The same formula with other parts in the place of those that hold no parts.
    pub(crate) fn replaced(
        &self,
        part: &dyn Fn(&Self) -> Self,
        known: &mut Known<Self, Shared<Self>>,
    ) -> Self {
        let mut of = |inner: &Expression| inner.replaced(part, known);
        match self {
            Expression::Constant(_)
            | Expression::Pi
            | Expression::Variable(_)
            | Expression::Parameter(_) => part(self),
            Expression::Sum(terms) => Expression::Sum(terms.iter().map(of).collect()),
            Expression::Product(factors) => Expression::Product(factors.iter().map(of).collect()),
            Expression::Negate(operand) => Expression::Negate(Box::new(of(operand))),
            Expression::Quotient(above, below) => {
                Expression::Quotient(Box::new(of(above)), Box::new(of(below)))
            }
            Expression::Power(base, exponent) => {
                Expression::Power(Box::new(of(base)), Box::new(of(exponent)))
            }
            Expression::Apply(function, argument) => {
                Expression::Apply(*function, Box::new(of(argument)))
            }
            Expression::Where(parts) => Expression::Where(Box::new(parts.each_ref().map(of))),
            Expression::Shared(shared) => {
                Expression::Shared(known.get(shared).unwrap_or_else(|| {
                    let replaced = shared.replaced(part, known);
                    let replaced = Shared::new(replaced, shared.height());
                    known.insert(shared, replaced.clone());
                    replaced
                }))
            }
        }
    }

    /// The formula as one that several others may hold: each of them evaluates it once, wherever and how often
    /// it stands there.
    ///
    /// ```
    /// use leafwise_expression::{Expression, Quantity};
    ///
    /// // x^(2^40), by forty squares.
    /// let power = (0..40).fold(Expression::from(Quantity::Variable(0)), |power, _| {
    ///     let power = power.shared();
    ///     &power * &power
    /// });
    /// assert_eq!(power.evaluate(&[-1.0], &[]), 1.0);
    /// ```
    pub fn shared(self) -> Self {
        let height = self.height();
        Self::Shared(Shared::new(self, height))
    }

    /// The levels of nesting, 0 for a number or a name.
    pub fn height(&self) -> usize {
        let highest =
            |parts: &[Expression]| parts.iter().map(Expression::height).max().unwrap_or(0);
        match self {
            Expression::Constant(_)
            | Expression::Pi
            | Expression::Variable(_)
            | Expression::Parameter(_) => 0,
            Expression::Sum(parts) | Expression::Product(parts) => 1 + highest(parts),
            Expression::Negate(part) | Expression::Apply(_, part) => 1 + part.height(),
            Expression::Quotient(left, right) | Expression::Power(left, right) => {
                1 + left.height().max(right.height())
            }
            Expression::Where(parts) => 1 + highest(parts.as_slice()),
            Expression::Shared(shared) => shared.height(),
        }
    }

    /// Whether it is smooth in pieces: whether it holds a choice, a magnitude, a sign or a largest integer below.
    pub fn has_seams(&self) -> bool {
        let mut found = false;
        self.visit(&mut |part| {
            found |= match part {
                Expression::Where(_) => true,
                Expression::Apply(function, _) => function.is_step() || *function == Function::Abs,
                _ => false,
            };
        });
        found
    }

    /// The integer this expression is, when it is written as a constant or a negated one.
    fn integer(&self) -> Option<i64> {
        match self {
            Expression::Constant(number) => number.to_i64(),
            Expression::Negate(operand) => operand.integer()?.checked_neg(),
            Expression::Shared(shared) => shared.integer(),
            _ => None,
        }
    }

    /// Calls `inspect` with every part, of what is shared once.
    fn visit(&self, inspect: &mut impl FnMut(&Expression)) {
        self.visit_new(inspect, &mut Known::default());
    }

    fn visit_new(&self, inspect: &mut impl FnMut(&Expression), known: &mut Known<Self, ()>) {
        inspect(self);
        match self {
            Expression::Constant(_)
            | Expression::Pi
            | Expression::Variable(_)
            | Expression::Parameter(_) => {}
            Expression::Sum(parts) | Expression::Product(parts) => {
                parts.iter().for_each(|part| part.visit_new(inspect, known));
            }
            Expression::Negate(part) | Expression::Apply(_, part) => part.visit_new(inspect, known),
            Expression::Quotient(left, right) | Expression::Power(left, right) => {
                left.visit_new(inspect, known);
                right.visit_new(inspect, known);
            }
            Expression::Where(parts) => {
                parts.iter().for_each(|part| part.visit_new(inspect, known));
            }
            Expression::Shared(shared) => {
                if known.insert(shared, ()).is_none() {
                    shared.visit_new(inspect, known);
                }
            }
        }
    }
}

/// base^exponent by repeated squaring; the reciprocal of the positive power when the exponent is
/// negative.
pub(crate) fn integer_power(base: f64, exponent: i64) -> f64 {
    let mut remaining = exponent.unsigned_abs();
    let mut square = base;
    let mut power = 1.0;
    while remaining > 0 {
        if remaining & 1 == 1 {
            power *= square;
        }
        remaining >>= 1;
        if remaining > 0 {
            square *= square;
        }
    }
    if exponent < 0 { 1.0 / power } else { power }
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

    #[test]
    fn evaluation_follows_the_tree() {
        let x = || Box::new(Expression::Variable(1));
        let constant = |value| Expression::Constant(Rational::from_integer(value));
        let tree = Expression::Sum(vec![
            Expression::Power(x(), Box::new(Expression::Negate(Box::new(constant(2))))),
            Expression::Product(vec![Expression::Parameter(0), Expression::Pi]),
            Expression::Negate(Box::new(Expression::Quotient(x(), Box::new(constant(8))))),
            Expression::Apply(Function::Exp, Box::new(constant(0))),
        ]);
        let expected = 1.0 / 16.0 + 2.0 * std::f64::consts::PI - 0.5 + 1.0;
        assert_eq!(tree.evaluate(&[f64::NAN, 4.0], &[2.0]), expected);
        assert_eq!(tree.variables().into_iter().collect::<Vec<_>>(), [1]);
        assert_eq!(tree.parameters().into_iter().collect::<Vec<_>>(), [0]);
        let fixed = tree.with_parameters(&[Rational::from_integer(2)]);
        assert_eq!(fixed.evaluate(&[f64::NAN, 4.0], &[]), expected);
    }

    #[test]
    fn integer_powers_are_exact_on_small_integers() {
        assert_eq!(integer_power(-3.0, 5), -243.0);
        assert_eq!(integer_power(2.0, -10), 1.0 / 1024.0);
        assert_eq!(integer_power(0.0, 0), 1.0);
        assert_eq!(integer_power(1.0, i64::MIN), 1.0);
    }
}
