//! Exact derivatives of straight-line code, again as straight-line code.

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::arithmetic::{AlgebraError, Arithmetic, function_derivative};
use crate::rational::Rational;

impl Graph {
    /// ∂(term)/∂(input), shared with everything already in the graph.
    ///
    /// # Errors
    /// [`AlgebraError`] when the derivative of a function does not exist.
    pub fn derivative(&mut self, term: &Term, input: usize) -> Result<Term, AlgebraError> {
        let input = u32::try_from(input).expect("fewer than 2^32 inputs");
        let inner = self.node_derivative(term.node, input)?;
        Ok(self.scale(&term.scale, &inner))
    }

    fn node_derivative(&mut self, node: Node, input: u32) -> Result<Term, AlgebraError> {
        if self.tier(node) != Tier::Step {
            return Ok(self.zero());
        }
        if let Operation::Input(index) = *self.operation(node) {
            return Ok(if index == input {
                self.one()
            } else {
                self.zero()
            });
        }
        if let Some(known) = self.derivatives.get(&(node, input)) {
            return Ok(known.clone());
        }
        let unit = |node| Term {
            scale: Rational::one(),
            node,
        };
        let result = match self.operation(node).clone() {
            Operation::One
            | Operation::Pi
            | Operation::Parameter(_)
            | Operation::StepSize(_)
            | Operation::Input(_) => self.zero(),
            Operation::Sum(terms) => {
                let mut parts = Vec::with_capacity(terms.len());
                for (scale, inner) in &terms {
                    parts.push((scale.clone(), self.node_derivative(*inner, input)?));
                }
                self.combine(&parts)
            }
            Operation::Scale(scale, inner) => {
                let inner = self.node_derivative(inner, input)?;
                self.scale(&scale, &inner)
            }
            Operation::Product(a, b) => {
                let da = self.node_derivative(a, input)?;
                let db = self.node_derivative(b, input)?;
                let left = self.multiply(&da, &unit(b));
                let right = self.multiply(&unit(a), &db);
                self.add(&left, &right)
            }
            Operation::Reciprocal(a) => {
                let inner = self.node_derivative(a, input)?;
                if self.is_zero(&inner) {
                    inner
                } else {
                    let square = self.multiply(&unit(node), &unit(node));
                    let product = self.multiply(&square, &inner);
                    self.negate(&product)
                }
            }
            Operation::Function(function, a) => {
                let inner = self.node_derivative(a, input)?;
                if self.is_zero(&inner) {
                    inner
                } else {
                    let outer = function_derivative(self, function, &unit(a), &unit(node))?;
                    self.multiply(&outer, &inner)
                }
            }
            Operation::Analytic(function, order, a) => {
                let inner = self.node_derivative(a, input)?;
                if self.is_zero(&inner) {
                    inner
                } else {
                    let outer = self.apply_analytic(function, order + 1, &unit(a));
                    self.multiply(&outer, &inner)
                }
            }
            Operation::Power(a, exponent) => {
                let inner = self.node_derivative(a, input)?;
                if self.is_zero(&inner) {
                    inner
                } else {
                    // a^(b−1), not a^b/a: finite at a = 0 for b ≥ 1.
                    let one = self.one();
                    let lower = self.subtract(&unit(exponent), &one);
                    let power = match self.as_rational(&lower).and_then(|r| r.to_i64()) {
                        Some(integer) => self.integer_power(&unit(a), integer)?,
                        None => self.power(&unit(a), &lower)?,
                    };
                    let outer = self.multiply(&unit(exponent), &power);
                    self.multiply(&outer, &inner)
                }
            }
        };
        self.derivatives.insert((node, input), result.clone());
        Ok(result)
    }
}
