//! Products in which what stands below cancels what stands above: x·(a − b/x) as a·x − b, defined at x = 0 too.

use super::node::{Graph, Node, Operation, Term};
use crate::arithmetic::Arithmetic;
use crate::rational::Rational;

/// Products of more factors are not looked into.
const MOST: usize = 16;

impl Graph {
    /// a·b with those terms of b reduced in which a factor of a stands below, or that have a factor of their own below
    /// in a. The other terms stay one product. Returns `None` where nothing cancels.
    pub(super) fn reduced_product(&mut self, a: &Term, b: &Term) -> Option<Term> {
        let above = self.factors(a.node)?;
        let may_cancel = |factor: &Node| {
            matches!(self.operation(*factor), Operation::Reciprocal(_))
                || self.find(&Operation::Reciprocal(*factor)).is_some()
        };
        if !above.iter().any(may_cancel) {
            return None;
        }
        let terms = match self.operation(b.node) {
            Operation::Sum(terms) => terms.to_vec(),
            _ => vec![(Rational::one(), b.node)],
        };
        let (mut reduced, mut rest) = (Vec::new(), Vec::new());
        for (scale, node) in terms {
            match self.reduced(&above, node) {
                Some(factors) => reduced.push((scale, factors)),
                None => rest.push((scale, Term::of(node))),
            }
        }
        if reduced.is_empty() {
            return None;
        }
        let mut sum = Vec::with_capacity(reduced.len() + 1);
        for (scale, factors) in reduced {
            let product = factors.into_iter().fold(self.one(), |product, factor| {
                self.multiply(&product, &Term::of(factor))
            });
            sum.push((scale, product));
        }
        if !rest.is_empty() {
            let rest = self.combine(&rest);
            let rest = self.multiply(&Term::of(a.node), &rest);
            sum.push((Rational::one(), rest));
        }
        let sum = self.combine(&sum);
        Some(self.scale(&(&a.scale * &b.scale), &sum))
    }

    /// The factors of a product with a node, without the pairs that cancel; `None` where none do.
    fn reduced(&self, above: &[Node], node: Node) -> Option<Vec<Node>> {
        let (mut left, mut own) = (above.to_vec(), self.factors(node)?);
        let before = own.len();
        own.retain(|factor| {
            let inverse = |other: &Node| {
                *self.operation(*factor) == Operation::Reciprocal(*other)
                    || *self.operation(*other) == Operation::Reciprocal(*factor)
            };
            match left.iter().position(inverse) {
                Some(at) => {
                    left.remove(at);
                    false
                }
                None => true,
            }
        });
        (own.len() < before).then(|| [left, own].concat())
    }

    /// The factors of a node, `None` where there are too many.
    fn factors(&self, node: Node) -> Option<Vec<Node>> {
        let (mut open, mut found) = (vec![node], Vec::new());
        while let Some(node) = open.pop() {
            match *self.operation(node) {
                Operation::Product(a, b) => open.extend([b, a]),
                _ => found.push(node),
            }
            if open.len() + found.len() > MOST {
                return None;
            }
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use crate::arithmetic::Arithmetic;
    use crate::expression::Function;
    use crate::graph::Graph;
    use crate::kernel::Kernel;
    use crate::rational::Rational;

    /// x y (a − b/x + y/(x z)) = a x y − b y + y²/z, and its slope by x is a y, at x = 0 and where 1/x² overflows.
    #[test]
    fn what_cancels_is_never_divided_by() {
        let mut graph = Graph::new();
        let [x, y, z] = [0, 1, 2].map(|at| graph.input(at));
        let (a, b) = (graph.parameter(0), graph.parameter(1));
        let sine = graph.apply(Function::Sin, &y).expect("a sine");
        let entry = graph.multiply(&x, &y);
        let second = graph.divide(&b, &x).expect("a quotient");
        let below = graph.multiply(&x, &z);
        let third = graph.divide(&y, &x).expect("a quotient");
        let third = graph.divide(&third, &z).expect("a quotient");
        let one = Rational::one();
        let slope = graph.combine(&[
            (one.clone(), a),
            (-&one, second),
            (one.clone(), third),
            (one, sine),
        ]);
        let product = graph.multiply_reduced(&entry, &slope);
        let by_x = graph.derivative(&product, 0).expect("it exists");
        // Nothing stands below here, and nothing changes.
        assert_eq!(
            graph.multiply_reduced(&below, &entry),
            graph.multiply(&below, &entry)
        );
        let kernel = Kernel::compile(&graph, &[product, by_x], 2, 3);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[3.0, 5.0], &[1.0], &[1.0]);
        for x in [0.0, 1e-300, -1e-170, 0.5, 2.0] {
            let (y, z): (f64, f64) = (1.5, 4.0);
            let mut found = [0.0; 2];
            kernel.evaluate(&mut workspace, &[x, y, z], &mut found);
            let inner = 3.0 + libm::sin(y);
            let expected = [x * y * inner - 5.0 * y + y * y / z, y * inner];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 64.0 * f64::EPSILON,
                    "{found} at {x}"
                );
            }
        }
    }
}
