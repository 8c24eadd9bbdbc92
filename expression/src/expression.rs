//! Resolved formulas: trees over numbered variables and parameters with exact constants.

use std::collections::BTreeSet;

use crate::function::kept;
pub use crate::function::{Binary, Function, Side};
use crate::rational::Rational;
use crate::shared::{Known, Shared};
use crate::table::Lookup;

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
    /// f(a, b).
    Binary(Binary, Box<[Expression; 2]>),
    /// A table, or one of its derivatives, at a point.
    Lookup(Lookup, Vec<Expression>),
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
            Expression::Binary(function, pair) => {
                let [a, b] = pair.each_ref().map(value);
                function.apply(a, b)
            }
            Expression::Lookup(lookup, point) => {
                lookup.at(&point.iter().map(value).collect::<Vec<_>>())
            }
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

    /// The tables and derivatives of tables that occur, in the order of the formula.
    pub fn lookups(&self) -> Vec<Lookup> {
        let mut found = Vec::new();
        self.visit(&mut |part| {
            if let Expression::Lookup(lookup, _) = part
                && !found.contains(lookup)
            {
                found.push(*lookup);
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

    /// The same formula of functions of its variables: `of(i)` in the place of i.
    pub fn at_formulas(&self, of: &dyn Fn(usize) -> Self) -> Self {
        let other = |part: &Expression| match part {
            Expression::Variable(index) => of(*index),
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
            Expression::Binary(function, pair) => {
                Expression::Binary(*function, Box::new(pair.each_ref().map(of)))
            }
            Expression::Lookup(lookup, point) => {
                Expression::Lookup(*lookup, point.iter().map(of).collect())
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
        if let Self::Shared(_) | Self::Constant(_) | Self::Variable(_) | Self::Parameter(_) = self {
            return self;
        }
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
            Expression::Sum(parts) | Expression::Product(parts) | Expression::Lookup(_, parts) => {
                1 + highest(parts)
            }
            Expression::Negate(part) | Expression::Apply(_, part) => 1 + part.height(),
            Expression::Quotient(left, right) | Expression::Power(left, right) => {
                1 + left.height().max(right.height())
            }
            Expression::Binary(_, pair) => 1 + highest(pair.as_slice()),
            Expression::Where(parts) => 1 + highest(parts.as_slice()),
            Expression::Shared(shared) => shared.height(),
        }
    }

    /// Whether it is smooth in pieces: whether it holds a choice, a remainder, a magnitude, a sign or a largest integer
    /// below, of what is not constant.
    pub fn has_seams(&self) -> bool {
        let mut found = false;
        self.visit(&mut |part| found = found || part.is_seam());
        found
    }

    /// Whether this part itself goes from piece to piece.
    fn is_seam(&self) -> bool {
        match self {
            Expression::Where(parts) => parts[0].has_variables(),
            Expression::Binary(function, pair) => {
                function.has_seams() && pair.iter().any(Expression::has_variables)
            }
            Expression::Apply(function, u) => {
                (function.is_step() || *function == Function::Abs) && u.has_variables()
            }
            _ => false,
        }
    }

    /// The formulas that decide of the piece in which a state is, each with a number of that piece. The number is the sign
    /// of c for a choice by c > 0, and of u for |u|. It is the integer itself for ⌊u⌋, and ⌊a/b⌋ for a remainder.
    pub fn seams(&self) -> Vec<[Expression; 2]> {
        let apply = |function, u: &Expression| Expression::Apply(function, Box::new(u.clone()));
        let mut seams: Vec<[Expression; 2]> = Vec::new();
        self.visit(&mut |part| {
            if !part.is_seam() {
                return;
            }
            seams.extend(match part {
                Expression::Where(parts) => {
                    Some([parts[0].clone(), apply(Function::Sign, &parts[0])])
                }
                Expression::Binary(_, pair) => {
                    let [a, b] = &**pair;
                    Some([part.clone(), apply(Function::Floor, &(a / b))])
                }
                Expression::Apply(Function::Floor, u) => Some([(**u).clone(), part.clone()]),
                Expression::Apply(_, u) => Some([(**u).clone(), apply(Function::Sign, u)]),
                _ => None,
            });
        });
        seams
    }

    /// Whether its value may jump: whether it has seams, or angles with their cut.
    pub fn may_jump(&self) -> bool {
        let mut has_angle = false;
        self.visit(&mut |part| has_angle |= matches!(part, Expression::Binary(..)));
        has_angle || self.has_seams()
    }

    /// Whether a variable occurs.
    fn has_variables(&self) -> bool {
        let mut found = false;
        self.visit(&mut |part| found |= matches!(part, Expression::Variable(_)));
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
    pub(crate) fn visit(&self, inspect: &mut impl FnMut(&Expression)) {
        self.visit_new(inspect, &mut Known::default());
    }

    fn visit_new(&self, inspect: &mut impl FnMut(&Expression), known: &mut Known<Self, ()>) {
        inspect(self);
        match self {
            Expression::Constant(_)
            | Expression::Pi
            | Expression::Variable(_)
            | Expression::Parameter(_) => {}
            Expression::Sum(parts) | Expression::Product(parts) | Expression::Lookup(_, parts) => {
                parts.iter().for_each(|part| part.visit_new(inspect, known));
            }
            Expression::Negate(part) | Expression::Apply(_, part) => part.visit_new(inspect, known),
            Expression::Quotient(left, right) | Expression::Power(left, right) => {
                left.visit_new(inspect, known);
                right.visit_new(inspect, known);
            }
            Expression::Binary(_, pair) => {
                pair.iter().for_each(|part| part.visit_new(inspect, known));
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
