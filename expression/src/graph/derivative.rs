//! Exact derivatives of straight-line code, again as straight-line code.

use super::node::{Graph, Node, Operation, Term, Tier};
use crate::arithmetic::{AlgebraError, Arithmetic, function_derivative};
use crate::expression::Function;
use crate::rational::Rational;
use crate::reach::{Reach, SumReach};

/// Sums of more terms than this are indexed.
const LONG: usize = 16;

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
            let reach = match *self.operation(next) {
                Operation::Input(index) => Reach::variable(index),
                _ if self.tier(next) != Tier::Step => Reach::nothing(),
                _ => Reach::union(self.operands(next).iter().map(|n| &self.reaches[n.index()])),
            };
            self.reaches.push(reach);
        }
        self.reaches[node.index()].may_contain(input)
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
