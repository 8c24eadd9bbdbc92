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
