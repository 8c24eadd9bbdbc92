//! Conditions as one number: how far they are from not holding.

use super::bound::Bound;
use super::composite::{Composite, Relation, choice};
use super::error::SyntaxError;
use super::formula::Formula;
use super::resolve::{Resolver, Stop};
use super::scope::Scope;
use super::tree::{Kind, Node};
use crate::expression::{Expression, Function};

/// Size of a [margin](Formula::margin) where both sides of a comparison are equal, 2⁻¹⁰⁰⁰: far below all that is compared.
pub const EQUAL_MARGIN: f64 = f64::from_bits(23 << 52);

impl Formula {
    /// A number that is positive where a [condition](Formula::parse_condition) holds, and negative where it does not. Of
    /// `a < b` it is b − a, of `a == b` −|a − b|. Where that is 0 it is [`EQUAL_MARGIN`] with the sign that tells. Of
    /// `and` it is the smaller one, of `or` the larger.
    ///
    /// Where a root of squares is compared, it is the difference of [squares](Expression::compared_magnitude).
    ///
    /// # Errors
    /// Those of [`Formula::resolve`].
    pub fn margin(&self, scope: &Scope) -> Result<Expression, SyntaxError> {
        let mut resolver = Resolver::new(self.source(), scope);
        match resolver.margin(self.root(), None) {
            Ok(margin) => Ok(margin),
            // No index is free.
            Err(Stop::Outside { .. }) => Ok(Expression::Sum(Vec::new())),
            Err(Stop::Error(error)) => Err(*error),
        }
    }

    /// Whether the condition, or a part of it, holds at single points alone, as `a == b`, which steps pass over.
    pub fn is_of_points(&self) -> bool {
        fn of(node: &Node, is_negated: bool) -> bool {
            match &node.kind {
                Kind::Compare(Relation::Equal, _) => !is_negated,
                Kind::Compare(Relation::NotEqual, _) => is_negated,
                Kind::Not(part) => of(part, !is_negated),
                Kind::And(parts) | Kind::Or(parts) => parts.iter().any(|part| of(part, is_negated)),
                _ => false,
            }
        }
        of(self.root(), false)
    }
}

impl Resolver<'_> {
    fn margin(&mut self, node: &Node, bound: Option<&Bound<'_>>) -> Result<Expression, Stop> {
        match &node.kind {
            Kind::Compare(relation, pair) => {
                let left = self.expression(&pair[0], bound)?;
                let right = self.expression(&pair[1], bound)?;
                let size = |difference| Expression::Apply(Function::Abs, Box::new(difference));
                let (margin, is_closed) = match relation {
                    Relation::Less => (difference(right, left), false),
                    Relation::LessOrEqual => (difference(right, left), true),
                    Relation::Greater => (difference(left, right), false),
                    Relation::GreaterOrEqual => (difference(left, right), true),
                    Relation::Equal => (-size(left - right), true),
                    Relation::NotEqual => (size(left - right), false),
                };
                Ok(never_zero(margin, is_closed))
            }
            Kind::Not(part) => Ok(-self.margin(part, bound)?),
            Kind::And(parts) | Kind::Or(parts) => {
                let margins = parts.iter().map(|part| self.margin(part, bound));
                let margins = margins.collect::<Result<_, _>>()?;
                Ok(match node.kind {
                    Kind::And(_) => Composite::Min.formula(margins),
                    _ => Composite::Max.formula(margins),
                })
            }
            // Conditions are made of comparisons.
            _ => self.expression(node, bound),
        }
    }
}

/// A function of the sign of left − right.
fn difference(left: Expression, right: Expression) -> Expression {
    Expression::compared_magnitude(&left, &right).unwrap_or_else(|| left - right)
}

/// m where it is not 0, and there a number that is positive where the comparison holds. NaN where m is.
fn never_zero(margin: Expression, is_closed: bool) -> Expression {
    let margin = margin.shared();
    let at_zero = if is_closed {
        EQUAL_MARGIN
    } else {
        -EQUAL_MARGIN
    };
    choice(
        margin.clone(),
        margin.clone(),
        choice(-margin.clone(), margin, at_zero.into()),
    )
}
