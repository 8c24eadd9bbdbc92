//! Nodes as formulas again.

use super::node::{Graph, Node, Operation, Term};
use crate::expression::Expression;
use crate::rational::Rational;

impl Graph {
    /// A formula of the same value, shared nodes written out wherever they are used. Returns `None` where it has more
    /// than `most` parts, or parts that no formula names: step sizes and functions of other crates.
    pub fn formula(&self, term: &Term, most: usize) -> Option<Expression> {
        let mut left = most;
        self.term_formula(&term.scale, term.node, &mut left)
    }

    /// Formulas of the same values in which nodes with several uses are [shared](Expression::shared); `None` where there are parts that
    /// no formula names.
    pub fn shared_formulas(&self, terms: &[Term]) -> Option<Vec<Expression>> {
        let is_read = self.read_by(terms);
        let mut uses = vec![0_usize; self.len()];
        for index in (0..self.len()).filter(|&index| is_read[index]) {
            let operands = self.operands(Node(index as u32));
            operands
                .iter()
                .for_each(|operand| uses[operand.index()] += 1);
        }
        terms.iter().for_each(|term| uses[term.node.index()] += 1);
        // Operands come before their uses.
        let mut known: Vec<Option<Expression>> = vec![None; self.len()];
        for index in (0..self.len()).filter(|&index| is_read[index]) {
            let node = Node(index as u32);
            let formula =
                self.operation_formula(node, &mut |operand| taken(&mut known, &uses, operand))?;
            let is_shared = uses[index] > 1 && !self.operands(node).is_empty();
            known[index] = Some(match is_shared {
                true => formula.shared(),
                false => formula,
            });
        }
        let of = |term: &Term| {
            Some(scaled(
                &term.scale,
                term.node,
                known[term.node.index()].clone()?,
            ))
        };
        terms.iter().map(of).collect()
    }

    fn term_formula(&self, scale: &Rational, node: Node, left: &mut usize) -> Option<Expression> {
        if node == Self::ONE || scale.is_zero() {
            return Some(Expression::Constant(scale.clone()));
        }
        Some(scaled(scale, node, self.node_formula(node, left)?))
    }

    fn node_formula(&self, node: Node, left: &mut usize) -> Option<Expression> {
        *left = left.checked_sub(1)?;
        self.operation_formula(node, &mut |operand| self.node_formula(operand, left))
    }

    /// A node by the formulas of its operands.
    fn operation_formula(
        &self,
        node: Node,
        of: &mut dyn FnMut(Node) -> Option<Expression>,
    ) -> Option<Expression> {
        let one = Rational::one();
        Some(match self.operation(node) {
            Operation::One => Expression::Constant(one),
            Operation::Pi => Expression::Pi,
            Operation::Parameter(index) => Expression::Parameter(*index as usize),
            Operation::Input(index) => Expression::Variable(*index as usize),
            Operation::StepSize(_) | Operation::Analytic(..) => return None,
            Operation::Sum(terms) => {
                let terms = terms.iter();
                let terms = terms.map(|(scale, node)| Some(scaled(scale, *node, of(*node)?)));
                Expression::Sum(terms.collect::<Option<_>>()?)
            }
            Operation::Scale(scale, node) => scaled(scale, *node, of(*node)?),
            Operation::Product(a, b) if a == b => Expression::Power(
                Box::new(of(*a)?),
                Box::new(Expression::Constant(Rational::from_integer(2))),
            ),
            Operation::Product(a, b) => Expression::Product(vec![of(*a)?, of(*b)?]),
            Operation::Reciprocal(a) => {
                Expression::Quotient(Box::new(Expression::Constant(one)), Box::new(of(*a)?))
            }
            Operation::Function(function, a) => Expression::Apply(*function, Box::new(of(*a)?)),
            Operation::Power(a, b) => Expression::Power(Box::new(of(*a)?), Box::new(of(*b)?)),
            Operation::Binary(function, a, b) => {
                Expression::Binary(*function, Box::new([of(*a)?, of(*b)?]))
            }
            Operation::Lookup(lookup, point) => {
                let point = point.iter().map(|at| of(*at));
                Expression::Lookup(*lookup, point.collect::<Option<_>>()?)
            }
            Operation::Kept(side, c, v) => Expression::kept(*side, of(*c)?, of(*v)?),
        })
    }
}

/// The formula of an operand, moved to its only use.
fn taken(known: &mut [Option<Expression>], uses: &[usize], operand: Node) -> Option<Expression> {
    let formula = &mut known[operand.index()];
    match uses[operand.index()] {
        1 => formula.take(),
        _ => formula.clone(),
    }
}

fn scaled(scale: &Rational, node: Node, value: Expression) -> Expression {
    let constant = Expression::Constant(scale.clone());
    if node == Graph::ONE || scale.is_zero() {
        constant
    } else if scale.is_one() {
        value
    } else {
        Expression::Product(vec![constant, value])
    }
}

#[cfg(test)]
mod tests {
    use crate::arithmetic::Arithmetic;
    use crate::expression::Function;
    use crate::graph::Graph;
    use crate::rational::Rational;
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

    /// The same from shared formulas: as many nodes as before, where the squares alone are 2²⁰ copies of x.
    #[test]
    fn shared_nodes_come_back_shared() {
        let mut graph = Graph::new();
        let x = graph.input(0);
        let power = (0..20).fold(x.clone(), |power, _| {
            let square = graph.multiply(&power, &power);
            graph.combine(&[(Rational::new(1, 2), square), (Rational::one(), x.clone())])
        });
        let root = graph.apply(Function::Sqrt, &power).expect("a root");
        let nodes = graph.len();
        let formulas = graph.shared_formulas(&[power.clone(), root.clone()]);
        let formulas = formulas.expect("formulas");
        let mut of = |formula: &crate::Expression| {
            let code =
                formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
            code.expect("code")
        };
        assert_eq!([of(&formulas[0]), of(&formulas[1])], [power, root]);
        assert_eq!(graph.len(), nodes);
    }
}
