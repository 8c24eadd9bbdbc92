//! From a formula to an exact expression at one site.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::scope::{Bound, LENGTH, Place, SUM, Scope, find};
use super::tree::{Kind, Node, Reference, Span};
use crate::expression::Expression;
use crate::operators::{negated, quotient};
use crate::rational::Rational;

/// The greatest magnitude of a constant exponent of an expression.
pub const POWER_LIMIT: i64 = 1000;

/// The greatest number of terms to which the sums of one formula may expand, together.
pub const TERM_LIMIT: usize = 1 << 20;

impl Formula {
    /// The expression that the formula is at one site.
    ///
    /// `index` is the name and the value of the free index. At an open boundary a summand of
    /// `sum(i, …)`, each of its additive terms, that reaches outside by way of `i` is dropped; a formula that reaches outside
    /// by way of the free index is absent: `Ok(None)`. Quotients and signs of numbers are carried
    /// out.
    ///
    /// # Errors
    /// [`SyntaxError`] when a name is unknown or misused, a fixed site does not exist, an index
    /// is used as a number, a constant exponent exceeds [`POWER_LIMIT`], or the sums have more
    /// than [`TERM_LIMIT`] terms.
    pub fn resolve(
        &self,
        scope: &Scope,
        index: Option<(&str, usize)>,
    ) -> Result<Option<Expression>, SyntaxError> {
        let outermost = index.map(|(name, value)| Bound {
            name,
            value,
            level: 0,
            outer: None,
        });
        let mut resolver = Resolver::new(self.text(), scope);
        match resolver.expression(self.root(), outermost.as_ref()) {
            Ok(expression) => Ok(Some(expression)),
            Err(Stop::Outside { .. }) => Ok(None),
            Err(Stop::Error(error)) => Err(*error),
        }
    }
}

/// Why a part has no expression. The error is boxed so that a level of recursion takes little of
/// the stack.
pub(super) enum Stop {
    Error(Box<SyntaxError>),
    /// The index of this level reaches beyond an open boundary.
    Outside {
        level: usize,
    },
}

impl From<SyntaxError> for Stop {
    fn from(error: SyntaxError) -> Self {
        Stop::Error(Box::new(error))
    }
}

pub(super) struct Resolver<'a> {
    text: &'a str,
    scope: &'a Scope,
    terms: usize,
}

impl<'a> Resolver<'a> {
    pub(super) fn new(text: &'a str, scope: &'a Scope) -> Self {
        Self {
            text,
            scope,
            terms: 0,
        }
    }

    pub(super) fn expression(
        &mut self,
        node: &Node,
        bound: Option<&Bound<'_>>,
    ) -> Result<Expression, Stop> {
        match &node.kind {
            Kind::Number { exact, .. } => Ok(Expression::Constant(exact.clone())),
            Kind::Pi => Ok(Expression::Pi),
            Kind::Length => self.length(node.span),
            Kind::Reference(reference) => self.reference(reference, bound),
            Kind::Call(function, argument) => {
                let argument = self.boxed(argument, bound)?;
                Ok(Expression::Apply(*function, argument))
            }
            Kind::SumOver { index, above, body } => {
                self.sum_over(node.span, (*index, *above), body, bound)
            }
            Kind::Sum(terms) => self.expressions(terms, bound).map(Expression::Sum),
            Kind::Product(factors) => self.expressions(factors, bound).map(Expression::Product),
            Kind::Negate(operand) => self.expression(operand, bound).map(negated),
            Kind::Quotient(pair) => {
                let numerator = self.expression(&pair[0], bound)?;
                Ok(quotient(numerator, self.expression(&pair[1], bound)?))
            }
            Kind::Power(pair) => {
                let base = self.boxed(&pair[0], bound)?;
                let exponent = self.boxed(&pair[1], bound)?;
                self.check_exponent(&exponent, pair[1].span)?;
                Ok(Expression::Power(base, exponent))
            }
        }
    }

    fn boxed(&mut self, node: &Node, bound: Option<&Bound<'_>>) -> Result<Box<Expression>, Stop> {
        self.expression(node, bound).map(Box::new)
    }

    fn length(&self, span: Span) -> Result<Expression, Stop> {
        let length = length(self.scope.shown_length(), span, LENGTH)?;
        Ok(Expression::Constant(Rational::from_integer(length as i64)))
    }

    fn expressions(
        &mut self,
        nodes: &[Node],
        bound: Option<&Bound<'_>>,
    ) -> Result<Vec<Expression>, Stop> {
        nodes
            .iter()
            .map(|node| self.expression(node, bound))
            .collect()
    }

    fn reference(
        &self,
        reference: &Reference,
        bound: Option<&Bound<'_>>,
    ) -> Result<Expression, Stop> {
        let name = reference.name.of(self.text);
        if reference.site.is_none() && find(bound, name).is_some() {
            let kind = SyntaxErrorKind::IndexAsNumber {
                name: name.to_owned(),
            };
            return Err(SyntaxError::new(reference.name, kind).into());
        }
        match self.scope.place(self.text, reference, bound)? {
            Place::Variable(index) => Ok(Expression::Variable(index)),
            Place::Parameter(index) => Ok(Expression::Parameter(index)),
            Place::Definition(index) => Ok(self.scope.definition(index).formula.clone()),
            Place::Outside { level } => Err(Stop::Outside { level }),
        }
    }

    fn check_exponent(&self, exponent: &Expression, span: Span) -> Result<(), SyntaxError> {
        match exponent {
            Expression::Constant(value) if value.abs() > Rational::from_integer(POWER_LIMIT) => {
                let exponent = span.of(self.text).chars().take(40).collect();
                let kind = SyntaxErrorKind::ExponentTooLarge {
                    exponent,
                    limit: POWER_LIMIT,
                };
                Err(SyntaxError::new(span, kind))
            }
            _ => Ok(()),
        }
    }

    fn sum_over(
        &mut self,
        span: Span,
        (index, above): (Span, Option<Span>),
        body: &Node,
        bound: Option<&Bound<'_>>,
    ) -> Result<Expression, Stop> {
        let length = length(self.scope.longest(), span, SUM)?;
        let mut inner = inner_index(self.text, index, bound)?;
        let mut terms = Vec::new();
        for value in first_value(self.text, above, bound)..length {
            self.terms += 1;
            check_terms(self.terms, span)?;
            inner.value = value;
            terms.extend(self.inside(body, &inner)?);
        }
        Ok(Expression::Sum(terms))
    }

    /// A summand without its additive terms that reach outside by way of the index `inner`; `None`
    /// when nothing is left. Constant factors and divisors are carried to the terms.
    pub(super) fn inside(
        &mut self,
        node: &Node,
        inner: &Bound<'_>,
    ) -> Result<Option<Expression>, Stop> {
        match &node.kind {
            Kind::Sum(terms) => {
                let mut kept = Vec::with_capacity(terms.len());
                for term in terms {
                    kept.extend(self.inside(term, inner)?);
                }
                Ok(if kept.is_empty() {
                    None
                } else {
                    Some(Expression::Sum(kept))
                })
            }
            Kind::Negate(operand) => Ok(self.inside(operand, inner)?.map(negated)),
            Kind::Quotient(pair) if pair[1].is_constant() => {
                let Some(above) = self.inside(&pair[0], inner)? else {
                    return Ok(None);
                };
                let below = self.expression(&pair[1], Some(inner))?;
                Ok(Some(quotient(above, below)))
            }
            Kind::Product(factors)
                if factors
                    .iter()
                    .filter(|factor| !factor.is_constant())
                    .count()
                    == 1 =>
            {
                let mut product = Vec::with_capacity(factors.len());
                for factor in factors {
                    let Some(factor) = self.inside(factor, inner)? else {
                        return Ok(None);
                    };
                    product.push(factor);
                }
                Ok(Some(Expression::Product(product)))
            }
            _ => match self.expression(node, Some(inner)) {
                Ok(term) => Ok(Some(term)),
                Err(Stop::Outside { level }) if level == inner.level => Ok(None),
                Err(stop) => Err(stop),
            },
        }
    }
}

/// The index of a sum, inside `bound`.
pub(super) fn inner_index<'a>(
    text: &'a str,
    span: Span,
    bound: Option<&'a Bound<'a>>,
) -> Result<Bound<'a>, SyntaxError> {
    let name = span.of(text);
    if find(bound, name).is_some() {
        let kind = SyntaxErrorKind::DuplicateIndex {
            name: name.to_owned(),
        };
        return Err(SyntaxError::new(span, kind));
    }
    // Level 0 is the caller's index, whether or not there is one.
    let level = bound.map_or(0, |outer| outer.level) + 1;
    Ok(Bound {
        name,
        value: 0,
        level,
        outer: bound,
    })
}

/// The first value of an index that is greater than that named `above`.
pub(super) fn first_value(text: &str, above: Option<Span>, bound: Option<&Bound<'_>>) -> usize {
    let lower = above.and_then(|span| find(bound, span.of(text)));
    lower.map_or(0, |lower| lower.value + 1)
}

/// `known`, or the error that no family gives `name` its length.
pub(super) fn length(
    known: Option<usize>,
    span: Span,
    name: &'static str,
) -> Result<usize, SyntaxError> {
    known.ok_or_else(|| SyntaxError::new(span, SyntaxErrorKind::LengthUnknown { name }))
}

pub(super) fn check_terms(terms: usize, span: Span) -> Result<(), SyntaxError> {
    if terms > TERM_LIMIT {
        let kind = SyntaxErrorKind::TooManyTerms { limit: TERM_LIMIT };
        return Err(SyntaxError::new(span, kind));
    }
    Ok(())
}
