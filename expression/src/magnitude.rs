//! Comparisons of magnitudes: √u − b has the sign of u − b|b|.

use crate::expression::{Expression, Function};
use crate::rational::Rational;
use crate::shared::Known;

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
        let (at, (factor, square)) = roots.next()?;
        if roots.next().is_some() {
            return None;
        }
        let (is_subtracted, _) = terms.remove(at);
        let is_negative = is_subtracted != factor.is_negative();
        let square = match &factor * &factor {
            factor if factor.is_one() => square,
            factor => Self::Constant(factor) * square,
        };
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

/// As many terms are told apart at most: sums of definitions that stand in one another twice each grow without end.
const MOST: usize = 64;

/// The terms of a sum, and whether each is subtracted.
fn terms_of(sum: &Expression, is_negative: bool, terms: &mut Vec<(bool, Expression)>) {
    match sum {
        Expression::Sum(parts) => {
            for part in parts {
                terms_of(part, is_negative, terms);
            }
        }
        Expression::Negate(part) => terms_of(part, !is_negative, terms),
        Expression::Shared(part) if is_sum(part) && terms.len() < MOST => {
            terms_of(part, is_negative, terms);
        }
        _ => terms.push((is_negative, sum.clone())),
    }
}

fn is_sum(formula: &Expression) -> bool {
    match formula {
        Expression::Sum(_) | Expression::Negate(_) => true,
        Expression::Shared(part) => is_sum(part),
        _ => false,
    }
}

/// c ≠ 0 and u of c √u, where u is a sum of squares.
fn root(term: &Expression) -> Option<(Rational, Expression)> {
    let square = |u: &Expression| {
        let is_square = is_sum_of_squares(u, &mut Known::default());
        is_square.then(|| (Rational::one(), u.clone()))
    };
    let times = |c: &Rational, (factor, u): (Rational, Expression)| {
        let factor = c * &factor;
        (!factor.is_zero()).then_some((factor, u))
    };
    match term {
        Expression::Apply(Function::Sqrt, u) => square(u),
        Expression::Power(u, n) if number(n)? == Rational::new(1, 2) => square(u),
        Expression::Shared(part) => root(part),
        Expression::Negate(part) => times(&Rational::from(-1), root(part)?),
        Expression::Quotient(part, c) => {
            let c = number(c).filter(|c| !c.is_zero())?;
            times(&(&Rational::one() / &c), root(part)?)
        }
        Expression::Product(factors) => {
            let (mut c, mut found) = (Rational::one(), None);
            for factor in factors {
                match number(factor) {
                    Some(number) => c = &c * &number,
                    None if found.is_none() => found = Some(root(factor)?),
                    None => return None,
                }
            }
            times(&c, found?)
        }
        _ => None,
    }
}

/// The number that a formula is, where it is written as one: 2, −2, 1/2.
fn number(formula: &Expression) -> Option<Rational> {
    match formula {
        Expression::Constant(c) => Some(c.clone()),
        Expression::Negate(part) => Some(-&number(part)?),
        Expression::Shared(part) => number(part),
        Expression::Quotient(a, b) => {
            let b = number(b).filter(|b| !b.is_zero())?;
            Some(&number(a)? / &b)
        }
        _ => None,
    }
}

/// Whether a formula is a sum of squares, so that it is nowhere negative.
fn is_sum_of_squares(formula: &Expression, known: &mut Known<Expression, bool>) -> bool {
    if let Some(c) = number(formula) {
        return c >= Rational::zero();
    }
    match formula {
        Expression::Sum(parts) => parts.iter().all(|part| is_sum_of_squares(part, known)),
        Expression::Product(factors) => match &factors[..] {
            [a, b] if a == b => true,
            _ => factors.iter().all(|part| is_sum_of_squares(part, known)),
        },
        Expression::Quotient(a, b) => is_sum_of_squares(a, known) && is_sum_of_squares(b, known),
        Expression::Power(_, n) => {
            number(n).is_some_and(|n| (&n * &Rational::new(1, 2)).is_integer())
        }
        Expression::Shared(shared) => known.get(shared).unwrap_or_else(|| {
            let found = is_sum_of_squares(shared, known);
            known.insert(shared, found);
            found
        }),
        _ => false,
    }
}
