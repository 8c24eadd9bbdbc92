//! Conditions as one number: how far they are from not holding.

use super::composite::{Composite, Relation};
use super::error::SyntaxError;
use super::formula::Formula;
use super::resolve::{Resolver, Stop};
use super::scope::{Bound, Scope};
use super::tree::{Kind, Node};
use crate::expression::{Expression, Function};

impl Formula {
    /// A number that is positive where a [condition](Formula::parse_condition) holds, and negative where it does not. The
    /// flag says whether it holds where the number is 0. Of `a < b` it is b − a, of `a == b` −|a − b|. Of `and` it is the
    /// smaller one, of `or` the larger.
    ///
    /// # Errors
    /// Those of [`Formula::resolve`].
    pub fn margin(&self, scope: &Scope) -> Result<(Expression, bool), SyntaxError> {
        let mut resolver = Resolver::new(self.source(), scope);
        match resolver.margin(self.root(), None) {
            Ok(margin) => Ok(margin),
            // No index is free.
            Err(Stop::Outside { .. }) => Ok((Expression::Sum(Vec::new()), false)),
            Err(Stop::Error(error)) => Err(*error),
        }
    }

    /// Whether the condition holds at single points alone, as `a == b`, which steps pass over.
    pub fn is_of_points(&self) -> bool {
        fn of(node: &Node, is_negated: bool) -> bool {
            match &node.kind {
                Kind::Compare(Relation::Equal, _) => !is_negated,
                Kind::Compare(Relation::NotEqual, _) => is_negated,
                Kind::Not(part) => of(part, !is_negated),
                Kind::And(parts) | Kind::Or(parts) => {
                    let is_any = matches!(node.kind, Kind::And(_)) != is_negated;
                    match is_any {
                        true => parts.iter().any(|part| of(part, is_negated)),
                        false => parts.iter().all(|part| of(part, is_negated)),
                    }
                }
                _ => false,
            }
        }
        of(self.root(), false)
    }
}

impl Resolver<'_> {
    fn margin(
        &mut self,
        node: &Node,
        bound: Option<&Bound<'_>>,
    ) -> Result<(Expression, bool), Stop> {
        match &node.kind {
            Kind::Compare(relation, pair) => {
                let left = self.expression(&pair[0], bound)?;
                let right = self.expression(&pair[1], bound)?;
                let size = |difference| Expression::Apply(Function::Abs, Box::new(difference));
                Ok(match relation {
                    Relation::Less => (right - left, false),
                    Relation::LessOrEqual => (right - left, true),
                    Relation::Greater => (left - right, false),
                    Relation::GreaterOrEqual => (left - right, true),
                    Relation::Equal => (-size(left - right), true),
                    Relation::NotEqual => (size(left - right), false),
                })
            }
            Kind::Not(part) => {
                let (margin, is_closed) = self.margin(part, bound)?;
                Ok((-margin, !is_closed))
            }
            Kind::And(parts) | Kind::Or(parts) => {
                let is_and = matches!(node.kind, Kind::And(_));
                let mut margins = Vec::with_capacity(parts.len());
                let mut are_closed = Vec::with_capacity(parts.len());
                for part in parts {
                    let (margin, is_closed) = self.margin(part, bound)?;
                    margins.push(margin);
                    are_closed.push(is_closed);
                }
                let mut are_closed = are_closed.into_iter();
                Ok(match is_and {
                    true => (
                        Composite::Min.formula(margins),
                        are_closed.all(|closed| closed),
                    ),
                    false => (
                        Composite::Max.formula(margins),
                        are_closed.any(|closed| closed),
                    ),
                })
            }
            // Conditions are made of comparisons.
            _ => Ok((self.expression(node, bound)?, false)),
        }
    }
}
