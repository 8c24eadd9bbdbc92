//! From a formula to an exact expression at one site.

use super::bound::{At, Bound, find};
use super::composite::{choice, compared};
use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::matrices::entry_of_two;
use super::place::Place;
use super::scope::Scope;
use super::tree::{Kind, Node, Reference, Span};
use super::vocabulary::{DERIVATIVE, IF};
use crate::even_powers;
use crate::expression::Expression;
use crate::operators::{Quantity, negated, quotient};
use crate::rational::Rational;

/// The greatest magnitude of a constant exponent of an expression.
pub const POWER_LIMIT: i64 = 1000;

/// The most conditions joined by one word whose choice is that of the first with the others within.
const NESTED_PARTS: usize = 64;

/// The greatest number of terms to which the sums of one formula may expand, together.
pub const TERM_LIMIT: usize = 1 << 20;

impl Formula {
    /// The expression that the formula is at one site.
    ///
    /// `index` has the names of the free indices, one an axis, and the site. At an open boundary each additive term of a summand of
    /// `sum(i, …)` that reaches outside by way of `i` is dropped. Terms are those of (a + b)c and (a + b)/c too, where
    /// c stays inside. One term each are a power, a function, and a product of which two factors reach outside. A
    /// formula that reaches outside by way of the free index is absent: `Ok(None)`. Quotients and signs of numbers are
    /// carried out.
    ///
    /// # Errors
    /// [`SyntaxError`] when a name is unknown or misused, or a fixed site does not exist. Also when an index is used
    /// as a number, a constant exponent exceeds [`POWER_LIMIT`], or the sums have more than [`TERM_LIMIT`] terms.
    pub fn resolve(
        &self,
        scope: &Scope,
        index: Option<At<'_>>,
    ) -> Result<Option<Expression>, SyntaxError> {
        let mut resolver = Resolver::new(self.source(), scope);
        let mut resolve = |bound: Option<&Bound<'_>>| resolver.expression(self.root(), bound);
        match scope.at_site(index, 0, &mut resolve) {
            Ok(expression) => Ok(Some(expression)),
            Err(Stop::Outside { .. }) => Ok(None),
            Err(Stop::Error(error)) => Err(*error),
        }
    }

    /// The same of a summand at a site, such as a force on `q[i]`. Its additive terms that reach outside by way of a free index
    /// are dropped, as those of `sum(i, …)` are. `None` where nothing is left.
    ///
    /// ```
    /// use leafwise_expression::syntax::{Boundary, Formula, Scope};
    ///
    /// let scope = Scope::new().with_family("p", 0, 3).with_boundary(Boundary::Open);
    /// let force = Formula::parse("p[i]/2 + 3*(p[i] - p[i+1])").expect("a formula");
    /// let last = force.resolve_summand(&scope, Some((&["i"], 2))).expect("known names");
    /// assert_eq!(last.expect("terms of p[2]").evaluate(&[5.0, 7.0, 2.0], &[]), 7.0);
    /// ```
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve).
    pub fn resolve_summand(
        &self,
        scope: &Scope,
        index: Option<At<'_>>,
    ) -> Result<Option<Expression>, SyntaxError> {
        let mut resolver = Resolver::new(self.source(), scope);
        self.summand(&mut resolver, index)
    }

    /// The terms that [`resolve_summand`](Self::resolve_summand) drops at a site, as they are written.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve).
    pub fn left_out_of_summand(
        &self,
        scope: &Scope,
        index: At<'_>,
    ) -> Result<Vec<&str>, SyntaxError> {
        let mut resolver = Resolver::new(self.source(), scope);
        self.summand(&mut resolver, Some(index))?;
        let dropped = resolver.dropped.iter();
        Ok(dropped.map(|span| span.of(self.source())).collect())
    }

    fn summand(
        &self,
        resolver: &mut Resolver<'_>,
        index: Option<At<'_>>,
    ) -> Result<Option<Expression>, SyntaxError> {
        let scope = resolver.scope;
        let mut resolve = |bound: Option<&Bound<'_>>| match bound {
            Some(bound) => resolver.inside(self.root(), bound, 0),
            None => resolver.expression(self.root(), None).map(Some),
        };
        match scope.at_site(index, 0, &mut resolve) {
            Ok(expression) => Ok(expression),
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
    pub(super) scope: &'a Scope,
    terms: usize,
    /// Whether an index stands for its number, as in values of parameters.
    pub(super) has_numbers: bool,
    /// The bodies of sums that are variables, and the variable of the first one.
    pub(super) sums: Option<(usize, Vec<&'a Node>)>,
    /// The variable that the first entry of a matrix stands for, where those of two sites are variables.
    pub(super) entries_from: Option<usize>,
    /// The terms of summands that reach outside.
    pub(super) dropped: Vec<Span>,
}

impl<'a> Resolver<'a> {
    pub(super) fn new(text: &'a str, scope: &'a Scope) -> Self {
        Self {
            text,
            scope,
            terms: 0,
            has_numbers: false,
            sums: None,
            entries_from: None,
            dropped: Vec::new(),
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
                self.scope
                    .check_call(self.text, function.name(), node.span)?;
                let argument = self.expression(argument, bound)?;
                Ok(even_powers::apply(*function, argument))
            }
            Kind::Lookup(name, arguments) => {
                let (lookup, _, point) = self.scope.lookup(self.text, *name, arguments)?;
                let point = self.expressions(point, bound)?;
                Ok(match lookup {
                    Some(lookup) => Expression::Lookup(lookup, point),
                    None => 0.into(),
                })
            }
            Kind::Composite(composite, arguments) => {
                self.scope
                    .check_call(self.text, composite.name(), node.span)?;
                Ok(composite.formula(self.expressions(arguments, bound)?))
            }
            Kind::If(parts) => {
                self.scope.check_call(self.text, IF, node.span)?;
                let [condition, holds, other] = &**parts;
                let holds = self.expression(holds, bound)?.shared();
                let other = self.expression(other, bound)?.shared();
                self.choice(condition, holds, other, bound)
            }
            // Conditions stand in `if` alone.
            Kind::Compare(..) | Kind::And(_) | Kind::Or(_) | Kind::Not(_) => {
                let (one, zero) = (1.into(), 0.into());
                self.choice(node, one, zero, bound)
            }
            Kind::Derivative(pair) => {
                self.scope.check_call(self.text, DERIVATIVE, node.span)?;
                let formula = self.expression(&pair[0], bound)?;
                let by = match self.expression(&pair[1], bound)? {
                    Expression::Variable(index) => Quantity::Variable(index),
                    Expression::Parameter(index) => Quantity::Parameter(index),
                    _ => {
                        let name = pair[1].span.of(self.text).to_owned();
                        let kind = SyntaxErrorKind::DerivativeByFormula { name };
                        return Err(SyntaxError::new(pair[1].span, kind).into());
                    }
                };
                formula.derivative(by).map_err(|reason| {
                    SyntaxError::new(node.span, SyntaxErrorKind::NoDerivative { reason }).into()
                })
            }
            Kind::SumOver { index, above, body } => match self.variable_of(body) {
                Some(variable) => Ok(Expression::Variable(variable)),
                None => self.sum_over(node.span, (*index, *above), body, bound),
            },
            Kind::Sum(terms) => self.expressions(terms, bound).map(Expression::Sum),
            Kind::Product(factors) => self.expressions(factors, bound).map(even_powers::product),
            Kind::Negate(operand) => self.expression(operand, bound).map(negated),
            Kind::Quotient(pair) => {
                let numerator = self.expression(&pair[0], bound)?;
                Ok(quotient(numerator, self.expression(&pair[1], bound)?))
            }
            Kind::Power(pair) => {
                let base = self.expression(&pair[0], bound)?;
                let exponent = self.expression(&pair[1], bound)?;
                self.check_exponent(&exponent, pair[1].span)?;
                Ok(even_powers::power(base, exponent))
            }
        }
    }

    /// The variable that a sum of this body is. Parts of a condition are resolved once for each side.
    fn variable_of(&self, body: &Node) -> Option<usize> {
        let (first, bodies) = self.sums.as_ref()?;
        let at = bodies.iter().position(|own| std::ptr::eq(*own, body))?;
        Some(first + at)
    }

    /// a where the condition holds, b elsewhere.
    fn choice(
        &mut self,
        condition: &Node,
        a: Expression,
        b: Expression,
        bound: Option<&Bound<'_>>,
    ) -> Result<Expression, Stop> {
        match &condition.kind {
            Kind::Compare(relation, pair) => {
                let x = self.expression(&pair[0], bound)?;
                let y = self.expression(&pair[1], bound)?;
                Ok(compared(*relation, [x, y], a, b))
            }
            // Of many parts the number of those that decide is compared with 0, so that no value lies as deep as they are many.
            Kind::Or(parts) if parts.len() > NESTED_PARTS => {
                let holding = self.deciding(parts, [1, 0], bound)?;
                Ok(choice(holding, a, b))
            }
            Kind::And(parts) if parts.len() > NESTED_PARTS => {
                let failing = self.deciding(parts, [0, 1], bound)?;
                Ok(choice(failing, b, a))
            }
            // Each part takes both values: they are shared.
            Kind::Or(parts) => parts
                .iter()
                .rev()
                .try_fold(b, |b, part| self.choice(part, a.clone(), b.shared(), bound)),
            Kind::And(parts) => parts
                .iter()
                .rev()
                .try_fold(a, |a, part| self.choice(part, a.shared(), b.clone(), bound)),
            Kind::Not(part) => self.choice(part, b, a, bound),
            _ => self.expression(condition, bound),
        }
    }

    /// The sum over conditions of the first number where one holds, else of the second.
    fn deciding(
        &mut self,
        parts: &[Node],
        [holds, fails]: [i32; 2],
        bound: Option<&Bound<'_>>,
    ) -> Result<Expression, Stop> {
        let count = |part| self.choice(part, holds.into(), fails.into(), bound);
        let counts = parts.iter().map(count);
        counts.collect::<Result<_, _>>().map(Expression::Sum)
    }

    fn length(&self, span: Span) -> Result<Expression, Stop> {
        let length = self.scope.shown_length(span)?;
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
        if let Some(index) = find(bound, name).filter(|_| reference.sites.is_empty()) {
            if self.has_numbers {
                let number = Rational::from_integer(index.value as i64);
                return Ok(Expression::Constant(number));
            }
            let kind = SyntaxErrorKind::IndexAsNumber {
                name: name.to_owned(),
            };
            return Err(SyntaxError::new(reference.shown, kind).into());
        }
        match self.scope.place(self.text, reference, bound)? {
            Place::Variable(index) => Ok(Expression::Variable(index)),
            Place::Parameter(index) => Ok(Expression::Parameter(index)),
            Place::Definition(index) => Ok(self.scope.definition(index).formula.clone()),
            Place::Entry { matrix, at } => match self.entries_from {
                Some(first) => Ok(Expression::Variable(first + entry_of_two(matrix, at))),
                None => {
                    let number = self.scope.matrices[matrix].at(at);
                    let exact = number.and_then(Rational::from_f64);
                    let unknown = || {
                        let name = name.to_owned();
                        let kind = SyntaxErrorKind::ParameterWithoutValue { name };
                        SyntaxError::new(reference.span(), kind)
                    };
                    Ok(Expression::Constant(exact.ok_or_else(unknown)?))
                }
            },
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
        indices: (Span, Option<Span>),
        body: &Node,
        bound: Option<&Bound<'_>>,
    ) -> Result<Expression, Stop> {
        let level = bound.map_or(0, |outer| outer.level) + 1;
        let terms = self.terms_of_sum(span, indices, body, (bound, level))?;
        Ok(Expression::Sum(terms))
    }

    /// The summands, without what reaches outside by way of an index of this level or an inner one.
    fn terms_of_sum(
        &mut self,
        span: Span,
        (index, above): (Span, Option<Span>),
        body: &Node,
        (bound, level): (Option<&Bound<'_>>, usize),
    ) -> Result<Vec<Expression>, Stop> {
        let length = self.scope.values_of(self.text, (index, above), body)?;
        let mut inner = inner_index(self.text, index, bound)?;
        inner.length = length;
        let mut terms = Vec::new();
        for value in first_value(self.text, above, bound)..length {
            self.terms += 1;
            check_terms(self.terms, span)?;
            inner.value = value;
            terms.extend(self.inside(body, &inner, level)?);
        }
        Ok(terms)
    }

    /// A summand without its additive terms that reach outside by way of an index of `level` or an inner one; `None`
    /// when nothing is left. Factors and divisors that stay inside are carried to the terms.
    pub(super) fn inside(
        &mut self,
        node: &Node,
        bound: &Bound<'_>,
        level: usize,
    ) -> Result<Option<Expression>, Stop> {
        match &node.kind {
            Kind::Sum(terms) => {
                let mut kept = Vec::with_capacity(terms.len());
                for term in terms {
                    kept.extend(self.inside(term, bound, level)?);
                }
                Ok(some_sum(kept))
            }
            Kind::SumOver { index, above, body } => {
                let within = (Some(bound), level);
                let kept = self.terms_of_sum(node.span, (*index, *above), body, within)?;
                Ok(some_sum(kept))
            }
            Kind::Negate(operand) => Ok(self.inside(operand, bound, level)?.map(negated)),
            Kind::Quotient(pair) => {
                let Some(below) = self.whole(&pair[1], bound, level)? else {
                    self.dropped.push(node.span);
                    return Ok(None);
                };
                let above = self.inside_of(node.span, &pair[0], bound, level)?;
                Ok(above.map(|above| quotient(above, below)))
            }
            Kind::Product(factors) => {
                let mut product = Vec::with_capacity(factors.len());
                let mut outside = Vec::new();
                for (at, factor) in factors.iter().enumerate() {
                    let whole = self.whole(factor, bound, level)?;
                    if whole.is_none() {
                        outside.push(at);
                    }
                    product.push(whole.unwrap_or_else(|| Expression::Sum(Vec::new())));
                }
                match outside[..] {
                    [] => {}
                    [at] => match self.inside_of(node.span, &factors[at], bound, level)? {
                        Some(factor) => product[at] = factor,
                        None => return Ok(None),
                    },
                    _ => {
                        self.dropped.push(node.span);
                        return Ok(None);
                    }
                }
                Ok(Some(Expression::Product(product)))
            }
            // What is raised to the power 1 is itself.
            Kind::Power(pair) if matches!(&pair[1].kind, Kind::Number { exact, .. } if *exact == Rational::one()) =>
            {
                let base = self.inside(&pair[0], bound, level)?;
                let one = || Box::new(Expression::Constant(Rational::one()));
                Ok(base.map(|base| Expression::Power(Box::new(base), one())))
            }
            _ => {
                let whole = self.whole(node, bound, level)?;
                if whole.is_none() {
                    self.dropped.push(node.span);
                }
                Ok(whole)
            }
        }
    }

    /// [`Self::inside`] of a part of what stands at `span`, which is dropped as a whole where nothing is left of the part.
    fn inside_of(
        &mut self,
        span: Span,
        part: &Node,
        bound: &Bound<'_>,
        level: usize,
    ) -> Result<Option<Expression>, Stop> {
        let before = self.dropped.len();
        let left = self.inside(part, bound, level)?;
        if left.is_none() {
            self.dropped.truncate(before);
            self.dropped.push(span);
        }
        Ok(left)
    }

    /// A part as a whole; `None` where it reaches outside by way of an index of `level` or an inner one.
    fn whole(
        &mut self,
        node: &Node,
        bound: &Bound<'_>,
        level: usize,
    ) -> Result<Option<Expression>, Stop> {
        match self.expression(node, Some(bound)) {
            Ok(whole) => Ok(Some(whole)),
            Err(Stop::Outside { level: own }) if own >= level => Ok(None),
            Err(stop) => Err(stop),
        }
    }
}

/// A sum of what is left, if anything is.
fn some_sum(terms: Vec<Expression>) -> Option<Expression> {
    (!terms.is_empty()).then_some(Expression::Sum(terms))
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
        length: 0,
        level,
        outer: bound,
    })
}

/// The first value of an index that is greater than that named `above`.
pub(super) fn first_value(text: &str, above: Option<Span>, bound: Option<&Bound<'_>>) -> usize {
    let lower = above.and_then(|span| find(bound, span.of(text)));
    lower.map_or(0, |lower| lower.value + 1)
}

pub(super) fn check_terms(terms: usize, span: Span) -> Result<(), SyntaxError> {
    if terms > TERM_LIMIT {
        let kind = SyntaxErrorKind::TooManyTerms { limit: TERM_LIMIT };
        return Err(SyntaxError::new(span, kind));
    }
    Ok(())
}
