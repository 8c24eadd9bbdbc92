//! Exact derivatives of straight-line code, again as straight-line code.

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::arithmetic::{AlgebraError, Arithmetic, binary_derivative, function_derivative};
use crate::expression::Function;
use crate::rational::Rational;
use crate::reach::{Reach, SumReach};
use crate::table::Lookup;

/// Sums of more terms than this are indexed.
const LONG: usize = 16;

/// Most nodes that a linear combination forms for a term, and as many of its own. They are a sum of coefficients,
/// their factor and a product with it. A product forms as many.
const OF_TERM: usize = 3;

/// A derivative by one input forms at most two products and their sum beside what it does for each operand.
const OF_INPUT: usize = 5 * OF_TERM;

/// f′(a) forms at most so many nodes: that of a power is the longest, a difference, a sum, twelve squares, as many products and
/// a quotient.
const OF_SLOPE: usize = 32 * OF_TERM;

impl Graph {
    /// ∂(term)/∂(input), shared with everything already in the graph.
    ///
    /// # Errors
    /// [`AlgebraError`] when the derivative of a function does not exist, or past the graph's limit.
    pub fn derivative(&mut self, term: &Term, input: usize) -> Result<Term, AlgebraError> {
        let input = u32::try_from(input).expect("fewer than 2^32 inputs");
        if !self.may_depend(term.node, input) {
            let zero = self.zero();
            return self.unless_refused(zero);
        }
        let inner = self.node_derivative(term.node, input)?;
        let derivative = self.scale(&term.scale, &inner);
        self.unless_refused(derivative)
    }

    /// Whether the derivative of a node by an input may be other than 0.
    fn may_depend(&mut self, node: Node, input: u32) -> bool {
        while self.reaches.len() <= node.index() {
            let next = Node(self.reaches.len() as u32);
            let reach = self.reach(next, &self.reaches);
            self.reaches.push(reach);
        }
        self.reaches[node.index()].may_contain(input)
    }

    /// The inputs that the derivatives of a node depend on, of those that the nodes before it do.
    fn reach(&self, node: Node, before: &[Reach]) -> Reach {
        match *self.operation(node) {
            Operation::Input(index) => Reach::variable(index),
            _ if self.tier(node) != Tier::Step => Reach::nothing(),
            Operation::Analytic(function, ..) if function.is_held() => Reach::nothing(),
            _ => Reach::union(self.operands(node).iter().map(|n| &before[n.index()])),
        }
    }

    /// Whether the derivatives of all terms by the first `inputs` inputs stay within the graph's limit for certain, which takes
    /// less time to tell than to form them.
    pub fn has_room_for_slopes(&self, terms: &[Term], inputs: usize) -> bool {
        let room = self.most.saturating_sub(self.len());
        self.most == usize::MAX || self.most_nodes_of_slopes(terms, inputs) <= room
    }

    /// A bound on the nodes that these derivatives are formed of.
    fn most_nodes_of_slopes(&self, terms: &[Term], inputs: usize) -> usize {
        let mut most = 2 * OF_TERM * terms.len() * inputs;
        let mut reaches = Vec::with_capacity(self.len());
        for (at, is_read) in self.read_by(terms).into_iter().enumerate() {
            let node = Node(at as u32);
            let reach = self.reach(node, &reaches);
            let inputs_read = reach.count(inputs);
            if is_read && inputs_read > 0 {
                let operands = self.operands(node).into_iter();
                let of_operands = operands.map(|n: Node| {
                    let reach: &Reach = &reaches[n.index()];
                    OF_TERM * reach.count(inputs)
                });
                most += OF_INPUT * inputs_read + of_operands.sum::<usize>();
                most += match self.operation(node) {
                    Operation::Reciprocal(_)
                    | Operation::Function(..)
                    | Operation::Analytic(..)
                    | Operation::Lookup(..)
                    | Operation::Power(..) => OF_SLOPE,
                    Operation::Binary(..) => 2 * OF_SLOPE,
                    _ => 0,
                };
            }
            reaches.push(reach);
        }
        most
    }

    fn node_derivative(&mut self, node: Node, input: u32) -> Result<Term, AlgebraError> {
        if !self.may_depend(node, input) {
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
        self.index_sum(node);
        let result = match self.operation(node) {
            Operation::One
            | Operation::Pi
            | Operation::Parameter(_)
            | Operation::StepSize(_)
            | Operation::Input(_) => self.zero(),
            Operation::Sum(terms) => {
                let depending = self.depending(node, terms, input);
                let mut parts = Vec::with_capacity(depending.len());
                for (scale, inner) in depending {
                    parts.push((scale, self.node_derivative(inner, input)?));
                }
                self.combine(&parts)
            }
            Operation::Scale(scale, inner) => {
                let (scale, inner) = (scale.clone(), *inner);
                let inner = self.node_derivative(inner, input)?;
                self.scale(&scale, &inner)
            }
            &Operation::Product(a, b) => {
                let da = self.node_derivative(a, input)?;
                let db = self.node_derivative(b, input)?;
                let left = self.multiply(&da, &Term::of(b));
                let right = self.multiply(&Term::of(a), &db);
                self.add(&left, &right)
            }
            &Operation::Binary(function, a, b) => {
                let mut parts = Vec::with_capacity(2);
                for (by, operand) in [a, b].into_iter().enumerate() {
                    let inner = self.node_derivative(operand, input)?;
                    if !self.is_zero(&inner) {
                        let pair = [&Term::of(a), &Term::of(b)];
                        let outer = binary_derivative(self, function, pair, by)?;
                        parts.push((Rational::one(), self.multiply(&outer, &inner)));
                    }
                }
                self.combine(&parts)
            }
            Operation::Lookup(lookup, point) => {
                let (lookup, point) = (*lookup, point.clone());
                let mut sum = Vec::with_capacity(point.len());
                for (axis, at) in point.iter().enumerate() {
                    let inner = self.node_derivative(*at, input)?;
                    if !self.is_zero(&inner) {
                        let outer = self.slope_along(lookup, axis, &point)?;
                        sum.push((Rational::one(), self.multiply(&outer, &inner)));
                    }
                }
                self.combine(&sum)
            }
            &Operation::Kept(side, c, v) => {
                let inner = self.node_derivative(v, input)?;
                self.kept(side, &Term::of(c), &inner)?
            }
            &(Operation::Reciprocal(a)
            | Operation::Function(_, a)
            | Operation::Analytic(_, _, a)
            | Operation::Power(a, _)) => {
                let inner = self.node_derivative(a, input)?;
                if self.is_zero(&inner) {
                    inner
                } else {
                    let outer = self.outer_derivative(node)?;
                    self.multiply(&outer, &inner)
                }
            }
        };
        self.derivatives.insert((node, input), result.clone());
        Ok(result)
    }

    /// Notes which terms of a long sum depend on which inputs: by each of its inputs, it is then differentiated
    /// without a look at all of its terms.
    fn index_sum(&mut self, node: Node) {
        if let Operation::Sum(terms) = self.operation(node)
            && terms.len() > LONG
            && !self.sums.contains_key(&node)
        {
            let reaches = terms.iter().map(|term| &self.reaches[term.1.index()]);
            let index = SumReach::new(reaches);
            self.sums.insert(node, index);
        }
    }

    /// The terms of a sum whose derivative by the input may be other than 0, in their order.
    fn depending(
        &self,
        sum: Node,
        terms: &[(Rational, Node)],
        input: u32,
    ) -> Vec<(Rational, Node)> {
        match self.sums.get(&sum) {
            Some(index) => {
                let places = index.terms_of(input).into_iter();
                places.map(|at| terms[at].clone()).collect()
            }
            None => {
                let depends = |n: &Node| self.reaches[n.index()].may_contain(input);
                let depending = terms.iter().filter(|(_, inner)| depends(inner));
                depending.cloned().collect()
            }
        }
    }

    /// The derivative of a table along an axis, at a point.
    pub(super) fn slope_along(
        &mut self,
        lookup: Lookup,
        axis: usize,
        point: &[Node],
    ) -> Result<Term, AlgebraError> {
        let point: Vec<Term> = point.iter().copied().map(Term::of).collect();
        match lookup.derivative(axis) {
            Some(slope) => self.look_up(slope, &point),
            None => Ok(self.zero()),
        }
    }

    /// f′(a) of a node f(a): a reciprocal, a function or a power.
    pub(super) fn outer_derivative(&mut self, node: Node) -> Result<Term, AlgebraError> {
        Ok(match *self.operation(node) {
            // 1/(2 √(f²)) is wanted times f: 0 where f is.
            Operation::Function(Function::Sqrt, a) if self.is_square(a) => {
                let above_zero = self.above_zero(a);
                let root = self.apply(Function::Sqrt, &above_zero)?;
                let twice = self.scale(&Rational::from_integer(2), &root);
                let one = self.one();
                self.divide(&one, &twice)?
            }
            Operation::Function(function, a) => {
                function_derivative(self, function, &Term::of(a), &Term::of(node))?
            }
            Operation::Analytic(function, ..) if function.is_held() => self.zero(),
            Operation::Analytic(function, order, a) => match function.slope() {
                Some(slope) if order == 0 => {
                    let of = self.apply_analytic(slope.of, 0, &Term::of(a));
                    let one = self.one();
                    let [constant, factor] =
                        [slope.constant, slope.factor].map(Rational::from_integer);
                    self.combine(&[(constant, one), (factor, of)])
                }
                _ => self.apply_analytic(function, order + 1, &Term::of(a)),
            },
            Operation::Power(a, exponent) => {
                // a^(b−1), not a^b/a: finite at a = 0 for b ≥ 1.
                let exponent = match self.operation(exponent) {
                    Operation::Scale(number, Self::ONE) => Self::number(number.clone()),
                    _ => Term::of(exponent),
                };
                let a = Term::of(a);
                let one = self.one();
                let lower = self.subtract(&exponent, &one);
                // u^(b−1) is wanted times u′, which is of the size of √u: their product tends to 0 where b > 1/2.
                let vanishes = self
                    .as_rational(&exponent)
                    .is_some_and(|b| b > Rational::new(1, 2) && b < Rational::one());
                let a = match vanishes && self.is_sum_of_squares(a.node) {
                    true => self.above_zero(a.node),
                    false => a,
                };
                let power = match self.as_rational(&lower).and_then(|r| r.to_i64()) {
                    Some(integer) => self.integer_power(&a, integer)?,
                    None => self.power(&a, &lower)?,
                };
                self.multiply(&exponent, &power)
            }
            // −1/a² of a reciprocal.
            _ => {
                let square = self.multiply(&Term::of(node), &Term::of(node));
                self.negate(&square)
            }
        })
    }

    /// u + 2^−1000, the bits of u but where that is next to 0: negative powers of it are finite.
    fn above_zero(&mut self, node: Node) -> Term {
        let half = Rational::new(1, 2);
        let tiny = (0..1000).fold(Rational::one(), |tiny, _| &tiny * &half);
        let one = self.one();
        self.combine(&[(Rational::one(), Term::of(node)), (tiny, one)])
    }

    /// Whether a node is c f², c > 0.
    fn is_square(&self, node: Node) -> bool {
        match self.operation(node) {
            Operation::Product(a, b) => a == b,
            Operation::Scale(scale, inner) => !scale.is_negative() && self.is_square(*inner),
            _ => false,
        }
    }

    /// Whether a node is Σ cᵢ fᵢ², each c_i > 0: where it is 0 all f_i are.
    fn is_sum_of_squares(&self, node: Node) -> bool {
        match self.operation(node) {
            Operation::Scale(scale, inner) => {
                !scale.is_negative() && self.is_sum_of_squares(*inner)
            }
            Operation::Sum(terms) => terms.iter().all(|(scale, term)| {
                let is_square = *term == Self::ONE || self.is_square(*term);
                is_square && !scale.is_negative()
            }),
            _ => self.is_square(node),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// More than are told one by one.
    const INPUTS: usize = 24;

    const FUNCTIONS: [Function; 9] = [
        Function::Exp,
        Function::Ln,
        Function::Sqrt,
        Function::Sin,
        Function::Tan,
        Function::Tanh,
        Function::Asin,
        Function::Acosh,
        Function::Atan,
    ];

    /// Nodes from pairs of earlier ones, inputs and parameters among these.
    fn build(graph: &mut Graph, choices: &[(u8, usize, usize)]) -> Vec<Term> {
        let mut terms: Vec<Term> = (0..INPUTS).map(|at| graph.input(at)).collect();
        terms.extend((0..3).map(|at| graph.parameter(at)));
        for &(kind, a, b) in choices {
            let all = terms.len();
            let (a, b) = (&terms[a % all].clone(), &terms[b % all].clone());
            let next = match kind % 8 {
                0 => graph.combine(&[
                    (Rational::new(2, 3), a.clone()),
                    (-Rational::one(), b.clone()),
                ]),
                1 => {
                    let parts = terms.iter().step_by(1 + b.node.index() % 3);
                    let parts: Vec<_> = parts
                        .map(|part| (Rational::new(1, 7), part.clone()))
                        .collect();
                    graph.combine(&parts)
                }
                2 => graph.divide(a, b).unwrap_or_else(|_| a.clone()),
                3 => {
                    let exponent = graph.constant(&Rational::new(-5, 3));
                    graph.power(a, &exponent).expect("a power")
                }
                4 => {
                    let exponent = graph.parameter(b.node.index() % 3);
                    let square = graph.multiply(a, a);
                    graph.power(&square, &exponent).expect("a power")
                }
                5 => {
                    let function = FUNCTIONS[b.node.index() % FUNCTIONS.len()];
                    graph.apply(function, a).unwrap_or_else(|_| a.clone())
                }
                _ => graph.multiply(a, b),
            };
            terms.push(next);
        }
        terms.split_off(INPUTS + 3)
    }

    proptest! {
        /// A graph with room for the bound refuses no derivative, whatever it is of.
        #[test]
        fn what_has_room_is_formed(
            choices in prop::collection::vec((any::<u8>(), any::<usize>(), any::<usize>()), 1..30),
        ) {
            let mut graph = Graph::new();
            let outputs = build(&mut graph, &choices);
            let most = graph.len() + graph.most_nodes_of_slopes(&outputs, INPUTS);
            graph.most = most - 1;
            prop_assert!(!graph.has_room_for_slopes(&outputs, INPUTS));
            graph.most = most;
            prop_assert!(graph.has_room_for_slopes(&outputs, INPUTS));
            for output in &outputs {
                for input in 0..INPUTS {
                    prop_assert!(graph.derivative(output, input).is_ok());
                }
            }
        }
    }

    /// All x_i (Σ_j a_ij x_j), as of a food web: the bound grows as the number of products does, times what one forms.
    #[test]
    fn the_bound_of_a_web_is_that_of_its_products() {
        let mut graph = Graph::compilable();
        let x: Vec<Term> = (0..100).map(|at| graph.input(at)).collect();
        let rows = x.iter().map(|own| {
            let others = x.iter().enumerate();
            let parts: Vec<_> = others
                .map(|(at, other)| {
                    let product = graph.multiply(own, other);
                    (Rational::new(1, 2 + at as i64), product)
                })
                .collect();
            graph.combine(&parts)
        });
        let rows: Vec<Term> = rows.collect();
        assert!(graph.has_room_for_slopes(&rows, 100));
        // 100² entries; a row has 100 products of two inputs, half of them shared.
        let most = graph.most_nodes_of_slopes(&rows, 100);
        let products = 5050 * 2 * (OF_INPUT + OF_TERM);
        let sums = 100 * 100 * (OF_INPUT + 2 * OF_TERM);
        let scales = 100 * 100 * 2 * OF_TERM;
        let inputs = 100 * OF_INPUT;
        assert!(most <= products + sums + scales + inputs, "{most}");
    }
}
