//! Gradients by one sweep from the result to the inputs.

use std::collections::BTreeMap;

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;

impl Graph {
    /// ∂(term)/∂(input) for the inputs 0 … d−1, d = `inputs`, in reverse mode: at most a few
    /// operations for each of the term's, whatever d is.
    ///
    /// # Errors
    /// [`AlgebraError`] when the derivative of a function does not exist.
    pub fn gradient(&mut self, term: &Term, inputs: usize) -> Result<Vec<Term>, AlgebraError> {
        let mut gradient = vec![self.zero(); inputs];
        // Operands come before their uses: the largest node left has all its contributions.
        let mut adjoints: BTreeMap<Node, Vec<(Rational, Term)>> = BTreeMap::new();
        let one = self.one();
        adjoints.insert(term.node, vec![(term.scale.clone(), one)]);
        while let Some((node, contributions)) = adjoints.pop_last() {
            if self.tier(node) != Tier::Step {
                continue;
            }
            let adjoint = self.combine(&contributions);
            if self.is_zero(&adjoint) {
                continue;
            }
            if let Operation::Input(index) = *self.operation(node) {
                if let Some(component) = gradient.get_mut(index as usize) {
                    *component = adjoint;
                }
                continue;
            }
            for (operand, partial) in self.partials(node)? {
                let part = self.multiply(&partial, &adjoint);
                let entry = adjoints.entry(operand).or_default();
                entry.push((Rational::one(), part));
            }
        }
        Ok(gradient)
    }

    /// ∂(node)/∂(operand) for each of its operands of the step tier.
    fn partials(&mut self, node: Node) -> Result<Vec<(Node, Term)>, AlgebraError> {
        let partials = match self.operation(node).clone() {
            Operation::Sum(terms) => {
                let scaled = |(scale, inner): &(Rational, Node)| (*inner, self.constant(scale));
                terms.iter().map(scaled).collect()
            }
            Operation::Scale(scale, inner) => vec![(inner, self.constant(&scale))],
            Operation::Product(a, b) => vec![(a, Term::of(b)), (b, Term::of(a))],
            Operation::Reciprocal(a)
            | Operation::Function(_, a)
            | Operation::Analytic(_, _, a)
            | Operation::Power(a, _) => vec![(a, self.outer_derivative(node)?)],
            Operation::One
            | Operation::Pi
            | Operation::Parameter(_)
            | Operation::StepSize(_)
            | Operation::Input(_) => Vec::new(),
        };
        let of_state = |(operand, _): &(Node, Term)| self.tier(*operand) == Tier::Step;
        Ok(partials.into_iter().filter(of_state).collect())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::expression::Function;
    use crate::kernel::Kernel;

    const INPUTS: usize = 3;

    /// Nodes from pairs of earlier ones, each at most 1.6 in size, with slopes of at most 1.6 in both.
    fn build(graph: &mut Graph, choices: &[(u8, usize, usize)]) -> Term {
        let mut terms: Vec<Term> = (0..INPUTS).map(|at| graph.input(at)).collect();
        let half = Rational::new(1, 2);
        for &(kind, a, b) in choices {
            let (a, b) = (
                &terms[a % terms.len()].clone(),
                &terms[b % terms.len()].clone(),
            );
            let square = graph.multiply(a, a);
            let above_one = graph.one();
            let above_one = graph.add(&above_one, &square);
            let next = match kind % 5 {
                0 => graph.combine(&[(half.clone(), a.clone()), (-&half, b.clone())]),
                1 => {
                    let product = graph.multiply(a, b);
                    graph.scale(&half, &product)
                }
                2 => graph.apply(Function::Sin, a).expect("a sine"),
                3 => graph.divide(b, &above_one).expect("a quotient"),
                _ => {
                    let exponent = graph.constant(&Rational::new(-1, 3));
                    let power = graph.power(&above_one, &exponent).expect("a power");
                    graph.apply(Function::Atan, &power).expect("an arctangent")
                }
            };
            terms.push(next);
        }
        terms.pop().expect("inputs stand first")
    }

    proptest! {
        /// Both modes are exact and sum the same paths in another order; n nodes make slopes of at
        /// most 3.2ⁿ.
        #[test]
        fn reverse_and_forward_mode_agree(
            choices in prop::collection::vec((any::<u8>(), any::<usize>(), any::<usize>()), 1..10),
            x in prop::array::uniform3(-1.0_f64..1.0),
        ) {
            let mut graph = Graph::new();
            let f = build(&mut graph, &choices);
            let mut outputs = graph.gradient(&f, INPUTS).expect("derivatives exist");
            for at in 0..INPUTS {
                outputs.push(graph.derivative(&f, at).expect("derivatives exist"));
            }
            let kernel = Kernel::compile(&graph, &outputs, 0, INPUTS);
            let mut workspace = kernel.workspace(1);
            kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
            let mut values = [0.0; 2 * INPUTS];
            kernel.evaluate(&mut workspace, &x, &mut values);
            let (mut bound, mut slope) = (64.0 * f64::EPSILON, 1.0);
            for _ in &choices {
                slope *= 3.2;
            }
            bound *= slope;
            let (reverse, forward) = values.split_at(INPUTS);
            for (a, b) in reverse.iter().zip(forward) {
                prop_assert!((a - b).abs() <= bound, "{reverse:?} {forward:?}");
            }
        }
    }

    #[test]
    fn inputs_that_a_term_does_not_read_have_slope_zero() {
        let mut graph = Graph::new();
        let (x, unused) = (graph.input(0), 1);
        let cube = graph.integer_power(&x, 3).expect("a power");
        let gradient = graph.gradient(&cube, 2).expect("derivatives exist");
        assert!(graph.is_zero(&gradient[unused]));
        assert_eq!(gradient[0], graph.derivative(&cube, 0).expect("it exists"));
    }
}
