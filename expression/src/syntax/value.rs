//! From a formula to a number.

use super::bound::{At, Bound, find};
use super::composite::compared;
use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::place::Place;
use super::resolve::{Resolver, Stop, check_terms, first_value, inner_index};
use super::scope::{Entry, Scope};
use super::tree::{Kind, Node, Reference, Span};
use super::vocabulary::IF;
use crate::expression::{Expression, integer_power};

impl Formula {
    /// The value of a formula of the parameters, the index and `N`, such as an initial value.
    ///
    /// Each operation is rounded to a double, as by
    /// [`Expression::evaluate`](crate::expression::Expression::evaluate): a power whose exponent
    /// is written as an integer is formed by repeated squaring. Nothing is allocated. Outside a
    /// domain the value is NaN or infinite.
    ///
    /// # Errors
    /// [`SyntaxError`] when a name is unknown or is a state variable, or when `parameters` lacks a
    /// value. Also when the sums have more than [`TERM_LIMIT`](super::TERM_LIMIT) terms.
    pub fn value(
        &self,
        scope: &Scope,
        parameters: &[f64],
        index: Option<At<'_>>,
    ) -> Result<f64, SyntaxError> {
        self.value_with_sites(scope, (parameters, &|_| None), index)
    }

    /// [`value`](Self::value) where members of families that are parameters too have the values that `sites` has for their
    /// places in the state.
    ///
    /// # Errors
    /// As [`value`](Self::value), and where a member lies outside of an open boundary.
    pub fn value_with_sites(
        &self,
        scope: &Scope,
        (parameters, sites): (&[f64], &dyn Fn(usize) -> Option<f64>),
        index: Option<At<'_>>,
    ) -> Result<f64, SyntaxError> {
        let mut evaluator = Evaluator {
            sites,
            ..Evaluator::new(self.source(), scope, parameters)
        };
        let mut value = |bound: Option<&Bound<'_>>| evaluator.value(self.root(), bound);
        scope.at_site(index, 0, &mut value).map_err(|error| *error)
    }
}

pub(super) struct Evaluator<'a> {
    text: &'a str,
    scope: &'a Scope,
    parameters: &'a [f64],
    sites: &'a dyn Fn(usize) -> Option<f64>,
    terms: usize,
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(text: &'a str, scope: &'a Scope, parameters: &'a [f64]) -> Self {
        Self {
            text,
            scope,
            parameters,
            sites: &|_| None,
            terms: 0,
        }
    }

    /// The error is boxed so that a level of recursion takes little of the stack.
    pub(super) fn value(
        &mut self,
        node: &Node,
        bound: Option<&Bound<'_>>,
    ) -> Result<f64, Box<SyntaxError>> {
        match &node.kind {
            Kind::Number { rounded, .. } => Ok(*rounded),
            Kind::Pi => Ok(std::f64::consts::PI),
            Kind::Length => Ok(self.scope.shown_length(node.span)? as f64),
            Kind::Reference(reference) => Ok(self.reference(reference, bound)?),
            Kind::Call(function, argument) => {
                self.scope
                    .check_call(self.text, function.name(), node.span)?;
                Ok(function.apply(self.value(argument, bound)?))
            }
            Kind::Lookup(name, arguments) => {
                let (lookup, _, point) = self.scope.lookup(self.text, *name, arguments)?;
                let mut at = Vec::with_capacity(point.len());
                for part in point {
                    at.push(self.value(part, bound)?);
                }
                Ok(lookup.map_or(0.0, |lookup| lookup.at(&at)))
            }
            Kind::Composite(composite, arguments) => {
                self.scope
                    .check_call(self.text, composite.name(), node.span)?;
                let values = arguments.iter().map(|argument| self.value(argument, bound));
                let values: Vec<f64> = values.collect::<Result<_, _>>()?;
                let formula =
                    composite.formula((0..values.len()).map(Expression::Variable).collect());
                Ok(formula.evaluate(&values, &[]))
            }
            Kind::If(parts) => {
                self.scope.check_call(self.text, IF, node.span)?;
                let [condition, holds, other] = &**parts;
                let (a, b) = (self.value(holds, bound)?, self.value(other, bound)?);
                self.choice(condition, a, b, bound)
            }
            Kind::Compare(..) | Kind::And(_) | Kind::Or(_) | Kind::Not(_) => {
                self.choice(node, 1.0, 0.0, bound)
            }
            // What is differentiated is a formula of parameters: the index is a number in it.
            Kind::Derivative(_) => {
                let mut resolver = Resolver::new(self.text, self.scope);
                resolver.has_numbers = true;
                let resolved = resolver.expression(node, bound);
                let formula = resolved.map_err(|stop| match stop {
                    Stop::Error(error) => error,
                    Stop::Outside { .. } => Box::new(SyntaxError::new(
                        node.span,
                        SyntaxErrorKind::NotAFunctionOfParameters {
                            name: node.span.of(self.text).to_owned(),
                        },
                    )),
                })?;
                let is_known = formula.parameters().last() < Some(&self.parameters.len())
                    && formula.variables().is_empty();
                match is_known {
                    true => Ok(formula.evaluate(&[], self.parameters)),
                    false => Err(Box::new(SyntaxError::new(
                        node.span,
                        SyntaxErrorKind::NotAFunctionOfParameters {
                            name: node.span.of(self.text).to_owned(),
                        },
                    ))),
                }
            }
            Kind::SumOver { index, above, body } => {
                self.sum_over(node.span, (*index, *above), body, bound)
            }
            Kind::Sum(terms) => {
                let mut sum = 0.0;
                for term in terms {
                    sum += self.value(term, bound)?;
                }
                Ok(sum)
            }
            Kind::Product(factors) => {
                let mut product = 1.0;
                for factor in factors {
                    product *= self.value(factor, bound)?;
                }
                Ok(product)
            }
            Kind::Negate(operand) => Ok(-self.value(operand, bound)?),
            Kind::Quotient(pair) => Ok(self.value(&pair[0], bound)? / self.value(&pair[1], bound)?),
            Kind::Power(pair) => {
                let base = self.value(&pair[0], bound)?;
                match self.integer(&pair[1].kind) {
                    Some(exponent) => Ok(integer_power(base, exponent)),
                    None => Ok(libm::pow(base, self.value(&pair[1], bound)?)),
                }
            }
        }
    }

    /// a where the condition holds, b elsewhere.
    fn choice(
        &mut self,
        condition: &Node,
        a: f64,
        b: f64,
        bound: Option<&Bound<'_>>,
    ) -> Result<f64, Box<SyntaxError>> {
        match &condition.kind {
            Kind::Compare(relation, pair) => {
                let values = [self.value(&pair[0], bound)?, self.value(&pair[1], bound)?];
                let [x, y, a_at, b_at] = [0, 1, 2, 3].map(Expression::Variable);
                let formula = compared(*relation, [x, y], a_at, b_at);
                Ok(formula.evaluate(&[values[0], values[1], a, b], &[]))
            }
            Kind::Or(parts) => {
                let mut parts = parts.iter().rev();
                parts.try_fold(b, |b, part| self.choice(part, a, b, bound))
            }
            Kind::And(parts) => {
                let mut parts = parts.iter().rev();
                parts.try_fold(a, |a, part| self.choice(part, a, b, bound))
            }
            Kind::Not(part) => self.choice(part, b, a, bound),
            _ => self.value(condition, bound),
        }
    }

    fn sum_over(
        &mut self,
        span: Span,
        (index, above): (Span, Option<Span>),
        body: &Node,
        bound: Option<&Bound<'_>>,
    ) -> Result<f64, Box<SyntaxError>> {
        let length = self.scope.values_of(self.text, (index, above), body)?;
        let mut inner = inner_index(self.text, index, bound)?;
        inner.length = length;
        let mut sum = 0.0;
        for value in first_value(self.text, above, bound)..length {
            self.terms += 1;
            check_terms(self.terms, span)?;
            inner.value = value;
            sum += self.value(body, Some(&inner))?;
        }
        Ok(sum)
    }

    /// The integer that an exponent is, when it is a number or `N`, negated or not.
    fn integer(&self, kind: &Kind) -> Option<i64> {
        match kind {
            Kind::Number { exact, .. } => exact.to_i64(),
            Kind::Length => {
                i64::try_from(self.scope.shown_length(Span { start: 0, end: 0 }).ok()?).ok()
            }
            Kind::Negate(operand) => self.integer(&operand.kind)?.checked_neg(),
            _ => None,
        }
    }

    fn reference(
        &self,
        reference: &Reference,
        bound: Option<&Bound<'_>>,
    ) -> Result<f64, SyntaxError> {
        let name = reference.name.of(self.text);
        if reference.sites.is_empty()
            && let Some(index) = find(bound, name)
        {
            return Ok(index.value as f64);
        }
        let span = reference.span();
        let kind = match self.scope.entry(self.text, reference)? {
            Entry::Parameter(_) | Entry::Definition(_) if !reference.sites.is_empty() => {
                SyntaxErrorKind::NotAFamily {
                    name: name.to_owned(),
                }
            }
            Entry::Definition(index) if self.scope.definition(index).is_of_parameters => {
                let formula = &self.scope.definition(index).formula;
                match formula.parameters().last() {
                    Some(last) if *last >= self.parameters.len() => {
                        SyntaxErrorKind::ParameterWithoutValue {
                            name: name.to_owned(),
                        }
                    }
                    _ => return Ok(formula.evaluate(&[], self.parameters)),
                }
            }
            Entry::Parameter(index) => match self.parameters.get(index) {
                Some(value) => return Ok(*value),
                None => SyntaxErrorKind::ParameterWithoutValue {
                    name: name.to_owned(),
                },
            },
            Entry::Table(_) => SyntaxErrorKind::TableWithoutPoint {
                name: name.to_owned(),
            },
            Entry::Family { .. } if !reference.sites.is_empty() => {
                // The span ends before the bracket.
                let written = || format!("{}]", span.of(self.text));
                match self.scope.place(self.text, reference, bound)? {
                    Place::Variable(at) => match (self.sites)(at) {
                        Some(value) => return Ok(value),
                        None => SyntaxErrorKind::NotAFunctionOfParameters {
                            name: name.to_owned(),
                        },
                    },
                    _ => SyntaxErrorKind::OutsideBoundary { name: written() },
                }
            }
            Entry::Variable(_) | Entry::Family { .. } | Entry::Matrix(_) | Entry::Definition(_) => {
                SyntaxErrorKind::NotAFunctionOfParameters {
                    name: name.to_owned(),
                }
            }
        };
        Err(SyntaxError::new(span, kind))
    }
}
