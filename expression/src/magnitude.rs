//! Comparisons of magnitudes: √u − b has the sign of u − b|b|.

use crate::expression::{Expression, Function};
use crate::rational::Rational;

impl Expression {
    /// u − b|b| where `left − right` is c (√u − b), c > 0, of a sum of squares u. The sign is the same. Near u = 0 it turns as slowly
    /// as u does: √u turns within a small part of a step. Returns `None` unless one such root is compared.
    pub fn compared_magnitude(left: &Self, right: &Self) -> Option<Self> {
        let mut terms = Vec::new();
        terms_of(left, false, &mut terms);
        terms_of(right, true, &mut terms);
        let mut roots = terms
            .iter()
            .enumerate()
            .filter_map(|(at, (_, term))| Some((at, root(term)?)));
        let (at, square) = roots.next()?;
        if roots.next().is_some() {
            return None;
        }
        let (is_negative, _) = terms.remove(at);
        // s √u + rest = s (√u − b), b = −s rest.
        let rest = terms
            .into_iter()
            .map(|(sign, term)| match sign == is_negative {
                true => -term,
                false => term,
            });
        let other = rest
            .reduce(|sum, term| sum + term)
            .unwrap_or_else(|| Self::Constant(Rational::zero()));
        let size = Self::Apply(Function::Abs, Box::new(other.clone()));
        let difference = square - other * size;
        Some(if is_negative { -difference } else { difference })
    }
}

/// The terms of a sum, and whether each is subtracted.
fn terms_of(sum: &Expression, is_negative: bool, terms: &mut Vec<(bool, Expression)>) {
    match sum {
        Expression::Sum(parts) => {
            for part in parts {
                terms_of(part, is_negative, terms);
            }
        }
        Expression::Negate(part) => terms_of(part, !is_negative, terms),
        Expression::Product(factors) => match &factors[..] {
            [Expression::Constant(c), rest @ ..] if c.is_negative() => {
                let rest = std::iter::once(Expression::Constant(-c)).chain(rest.iter().cloned());
                terms.push((!is_negative, Expression::Product(rest.collect())));
            }
            _ => terms.push((is_negative, sum.clone())),
        },
        _ => terms.push((is_negative, sum.clone())),
    }
}

/// The square of √u or c √u, c > 0.
fn root(term: &Expression) -> Option<Expression> {
    match term {
        Expression::Apply(Function::Sqrt, u) if is_sum_of_squares(u) => Some((**u).clone()),
        Expression::Product(factors) => match &factors[..] {
            [Expression::Constant(c), factor] | [factor, Expression::Constant(c)]
                if *c > Rational::zero() =>
            {
                Some(Expression::Constant(c * c) * root(factor)?)
            }
            _ => None,
        },
        _ => None,
    }
}

/// Whether a formula is a sum of squares, so that it is nowhere negative.
fn is_sum_of_squares(formula: &Expression) -> bool {
    match formula {
        Expression::Constant(c) => *c >= Rational::zero(),
        Expression::Sum(parts) => parts.iter().all(is_sum_of_squares),
        Expression::Product(factors) => match &factors[..] {
            [a, b] if a == b => true,
            _ => factors.iter().all(is_sum_of_squares),
        },
        Expression::Quotient(a, b) => is_sum_of_squares(a) && is_sum_of_squares(b),
        Expression::Power(_, n) => {
            matches!(&**n, Expression::Constant(n) if (n * &Rational::new(1, 2)).is_integer())
        }
        Expression::Shared(shared) => is_sum_of_squares(shared),
        _ => false,
    }
}
