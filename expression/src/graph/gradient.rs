//! Gradients by one sweep from the result to the inputs.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::arithmetic::{AlgebraError, Arithmetic, binary_derivative};
use crate::expression::Function;
use crate::rational::Rational;

impl Graph {
    /// ∂(term)/∂(input) for the inputs 0 … d−1, d = `inputs`, in reverse mode. The cost is at most a few operations
    /// for each of the term's, whatever d is.
    ///
    /// # Errors
    /// [`AlgebraError`] when the derivative of a function does not exist.
    pub fn gradient(&mut self, term: &Term, inputs: usize) -> Result<Vec<Term>, AlgebraError> {
        let [gradient, _] = self.gradients(term, [inputs, 0])?;
        Ok(gradient)
    }

    /// The same and ∂(term)/∂(parameter) for so many `[inputs, parameters]`, by one sweep: through the coefficients to
    /// the parameters that they are made of.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    pub fn gradients(
        &mut self,
        term: &Term,
        [inputs, parameters]: [usize; 2],
    ) -> Result<[Vec<Term>; 2], AlgebraError> {
        let mut gradients = [inputs, parameters].map(|count| vec![self.zero(); count]);
        let lowest = if parameters == 0 {
            Tier::Step
        } else {
            Tier::Coefficient
        };
        for (node, slope) in self.slopes(term, lowest, &mut FxHashMap::default())? {
            let component = match *self.operation(node) {
                Operation::Input(index) => gradients[0].get_mut(index as usize),
                Operation::Parameter(index) => gradients[1].get_mut(index as usize),
                _ => None,
            };
            if let Some(component) = component {
                *component = slope;
            }
        }
        Ok(gradients)
    }

    /// ∂(term)/∂(input) for the inputs, and parameters, that it depends on. What stands behind a seam is differentiated
    /// once, however many seams there are on the way to it: `known` are the slopes of those parts.
    fn slopes(
        &mut self,
        term: &Term,
        lowest: Tier,
        known: &mut FxHashMap<Node, Vec<(Node, Term)>>,
    ) -> Result<Vec<(Node, Term)>, AlgebraError> {
        let mut slopes = Vec::new();
        // Operands come before their uses: the largest node left has all its contributions.
        let mut adjoints: BTreeMap<Node, Vec<(Rational, Term)>> = BTreeMap::new();
        let one = self.one();
        adjoints.insert(term.node, vec![(term.scale.clone(), one)]);
        while let Some((node, contributions)) = adjoints.pop_last() {
            if self.tier(node) < lowest {
                continue;
            }
            let adjoint = self.combine(&contributions);
            if self.is_zero(&adjoint) {
                continue;
            }
            match *self.operation(node) {
                Operation::Input(_) | Operation::Parameter(_) => slopes.push((node, adjoint)),
                // What stands behind a seam may have no value on the other side: it is left there before it is multiplied.
                Operation::Kept(side, c, v) => {
                    if !known.contains_key(&v) {
                        let inner = self.slopes(&Term::of(v), lowest, known)?;
                        known.insert(v, inner);
                    }
                    for (component, slope) in &known[&v] {
                        let slope = self.kept(side, &Term::of(c), slope)?;
                        let part = self.multiply(&slope, &adjoint);
                        let entry = adjoints.entry(*component).or_default();
                        entry.push((Rational::one(), part));
                    }
                }
                _ => {
                    for (operand, partial) in self.partials(node, lowest)? {
                        let part = self.multiply(&partial, &adjoint);
                        let entry = adjoints.entry(operand).or_default();
                        entry.push((Rational::one(), part));
                    }
                }
            }
        }
        Ok(slopes)
    }

    /// ∂(node)/∂(operand) for each of its operands from the tier `lowest` on.
    fn partials(&mut self, node: Node, lowest: Tier) -> Result<Vec<(Node, Term)>, AlgebraError> {
        let partials = match self.operation(node).clone() {
            Operation::Sum(terms) => {
                let scaled = |(scale, inner): &(Rational, Node)| (*inner, self.constant(scale));
                terms.iter().map(scaled).collect()
            }
            Operation::Scale(scale, inner) => vec![(inner, self.constant(&scale))],
            Operation::Product(a, b) => vec![(a, Term::of(b)), (b, Term::of(a))],
            Operation::Power(a, exponent) if self.tier(exponent) >= lowest => {
                // ∂(a^b)/∂b = a^b ln a.
                let logarithm = self.apply(Function::Ln, &Term::of(a))?;
                let of_exponent = self.multiply(&Term::of(node), &logarithm);
                vec![(a, self.outer_derivative(node)?), (exponent, of_exponent)]
            }
            Operation::Reciprocal(a)
            | Operation::Function(_, a)
            | Operation::Analytic(_, _, a)
            | Operation::Power(a, _) => vec![(a, self.outer_derivative(node)?)],
            Operation::Binary(function, a, b) => {
                let mut partials = Vec::with_capacity(2);
                for (by, operand) in [a, b].into_iter().enumerate() {
                    if self.tier(operand) >= lowest {
                        let pair = [&Term::of(a), &Term::of(b)];
                        partials.push((operand, binary_derivative(self, function, pair, by)?));
                    }
                }
                partials
            }
            Operation::Lookup(lookup, point) => {
                let mut slopes = Vec::with_capacity(point.len());
                for (axis, at) in point.iter().enumerate() {
                    if self.tier(*at) >= lowest {
                        slopes.push((*at, self.slope_along(lookup, axis, &point)?));
                    }
                }
                slopes
            }
            Operation::One
            | Operation::Pi
            | Operation::Parameter(_)
            | Operation::StepSize(_)
            | Operation::Input(_)
            | Operation::Kept(..) => Vec::new(),
        };
        let varies = |(operand, _): &(Node, Term)| self.tier(*operand) >= lowest;
        Ok(partials.into_iter().filter(varies).collect())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
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

    /// A parameter is an input that changes less often: the same code with inputs in the place of parameters has the same
    /// slopes, through coefficients, powers of coefficients and exponents.
    #[test]
    fn parameters_have_the_slopes_of_inputs_in_their_place() {
        let code = |graph: &mut Graph, at: [Term; 4]| -> Term {
            let [x, y, a, b] = at;
            let sum = graph.add(&a, &b);
            let root = graph.apply(Function::Sqrt, &sum).expect("a root");
            let inverse = graph.divide(&root, &a).expect("a quotient");
            let square = graph.multiply(&x, &x);
            let one = graph.one();
            let base = graph.add(&one, &square);
            // An exponent that changes with the state is one of exp.
            let power = match graph.tier(b.node) {
                Tier::Step => {
                    let logarithm = graph.apply(Function::Ln, &base).expect("a logarithm");
                    let exponent = graph.multiply(&b, &logarithm);
                    graph.apply(Function::Exp, &exponent).expect("a power")
                }
                _ => graph.power(&base, &b).expect("a power"),
            };
            let sine = graph.apply(Function::Sin, &inverse).expect("a sine");
            let product = graph.multiply(&power, &sine);
            let other = graph.multiply(&inverse, &y);
            graph.combine(&[(Rational::new(3, 7), product), (Rational::one(), other)])
        };
        let mut graph = Graph::new();
        let inputs: [Term; 4] = std::array::from_fn(|i| graph.input(i));
        let of_inputs = code(&mut graph, inputs.clone());
        let expected = graph.gradient(&of_inputs, 4).expect("derivatives exist");
        let [x, y, ..] = inputs;
        let (a, b) = (graph.parameter(0), graph.parameter(1));
        let of_parameters = code(&mut graph, [x, y, a, b]);
        let found = graph.gradients(&of_parameters, [2, 2]).expect("they exist");
        let outputs = [found.concat(), expected].concat();
        let kernel = Kernel::compile(&graph, &outputs, 2, 4);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[0.7, 1.3], &[1.0], &[1.0]);
        let mut values = [0.0; 8];
        kernel.evaluate(&mut workspace, &[-0.4, 2.1, 0.7, 1.3], &mut values);
        let (found, expected) = values.split_at(4);
        for (a, b) in found.iter().zip(expected) {
            assert!(
                (a - b).abs() <= 16.0 * f64::EPSILON * b.abs(),
                "{found:?} {expected:?}"
            );
        }
    }
}
