//! Nodes as formulas again.

use super::node::{Graph, Node, Operation, Term};
use crate::expression::Expression;
use crate::rational::Rational;

impl Graph {
    /// A formula of the same value, shared nodes written out wherever they are used; `None` where it
    /// has more than `most` parts, or parts that no formula names: step sizes and functions of other
    /// crates.
    pub fn formula(&self, term: &Term, most: usize) -> Option<Expression> {
        let mut left = most;
        self.term_formula(&term.scale, term.node, &mut left)
    }

    fn term_formula(&self, scale: &Rational, node: Node, left: &mut usize) -> Option<Expression> {
        let constant = Expression::Constant(scale.clone());
        if node == Self::ONE || scale.is_zero() {
            return Some(constant);
        }
        let value = self.node_formula(node, left)?;
        Some(match scale.is_one() {
            true => value,
            false => Expression::Product(vec![constant, value]),
        })
    }

    fn node_formula(&self, node: Node, left: &mut usize) -> Option<Expression> {
        *left = left.checked_sub(1)?;
        let one = Rational::one();
        let boxed = |node: Node, left: &mut usize| self.node_formula(node, left).map(Box::new);
        Some(match self.operation(node) {
            Operation::One => Expression::Constant(one),
            Operation::Pi => Expression::Pi,
            Operation::Parameter(index) => Expression::Parameter(*index as usize),
            Operation::Input(index) => Expression::Variable(*index as usize),
            Operation::StepSize(_) | Operation::Analytic(..) => return None,
            Operation::Sum(terms) => {
                let terms = terms.iter();
                let terms = terms.map(|(scale, node)| self.term_formula(scale, *node, left));
                Expression::Sum(terms.collect::<Option<_>>()?)
            }
            Operation::Scale(scale, node) => self.term_formula(scale, *node, left)?,
            Operation::Product(a, b) if a == b => Expression::Power(
                boxed(*a, left)?,
                Box::new(Expression::Constant(Rational::from_integer(2))),
            ),
            Operation::Product(a, b) => Expression::Product(vec![
                self.node_formula(*a, left)?,
                self.node_formula(*b, left)?,
            ]),
            Operation::Reciprocal(a) => {
                Expression::Quotient(Box::new(Expression::Constant(one)), boxed(*a, left)?)
            }
            Operation::Function(function, a) => Expression::Apply(*function, boxed(*a, left)?),
            Operation::Power(a, b) => Expression::Power(boxed(*a, left)?, boxed(*b, left)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::graph::Graph;
    use crate::syntax::{Formula, Scope};

    #[test]
    fn nodes_come_back_and_long_ones_do_not() {
        let scope = Scope::new()
            .with_variables(&["x", "y"])
            .with_parameters(&["a"]);
        let text = "x^2*y/(2*a) - ln(x)*sin(a*y)/3 + (x + y)^a + sqrt(x)*pi - 7";
        let formula = Formula::parse(text).expect(text);
        let written = formula.resolve(&scope, None).expect(text).expect(text);
        let mut graph = Graph::new();
        let term = written
            .evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)))
            .expect("code");
        let back = graph.formula(&term, 100).expect("short");
        let (x, a) = ([0.7, 1.9], [1.3]);
        let (value, expected) = (back.evaluate(&x, &a), written.evaluate(&x, &a));
        assert!((value - expected).abs() < 64.0 * f64::EPSILON, "{value}");
        assert_eq!(graph.formula(&term, 5), None);
    }
}
