//! Code of one graph written into another.

use super::node::{Graph, Node, Operation, Term};
use crate::arithmetic::{AlgebraError, Arithmetic};
use crate::rational::Rational;

impl Graph {
    /// `terms` of `other` with `inputs[i]` for its input i, written here.
    ///
    /// # Errors
    /// [`AlgebraError`] where an operation has no value on the new inputs, such as 1/0.
    pub fn import(
        &mut self,
        other: &Self,
        terms: &[Term],
        inputs: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        let is_read = other.read_by(terms);
        // Operands come before their uses.
        let mut known: Vec<Option<Term>> = vec![None; other.len()];
        for index in (0..other.len()).filter(|&index| is_read[index]) {
            let code = self.import_node(other.operation(Node(index as u32)), &known, inputs)?;
            known[index] = Some(code);
        }
        let of = |node: Node| known[node.index()].as_ref();
        let scaled = |term: &Term| {
            let code = of(term.node).expect("what is read was written");
            self.scale(&term.scale, code)
        };
        Ok(terms.iter().map(scaled).collect())
    }

    /// `terms` with `inputs[i]` for input i, in any algebra.
    ///
    /// # Errors
    /// [`AlgebraError::NoSeries`] for step sizes and functions of other crates; otherwise where an operation has
    /// no value on the inputs.
    pub fn evaluate_in<A: Arithmetic>(
        &self,
        algebra: &mut A,
        terms: &[Term],
        inputs: &[A::Element],
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let is_read = self.read_by(terms);
        let mut known: Vec<Option<A::Element>> = vec![None; self.len()];
        for index in (0..self.len()).filter(|&index| is_read[index]) {
            let of = |node: Node| known[node.index()].clone().expect("operands come first");
            let value = match self.operation(Node(index as u32)) {
                Operation::One => algebra.one(),
                Operation::Pi => algebra.pi(),
                Operation::Parameter(index) => algebra.parameter(*index as usize),
                Operation::Input(index) => inputs[*index as usize].clone(),
                Operation::Sum(terms) => {
                    let terms = terms.iter().map(|(scale, node)| (scale.clone(), of(*node)));
                    let terms: Vec<_> = terms.collect();
                    algebra.combine(&terms)
                }
                Operation::Scale(scale, a) => algebra.scale(scale, &of(*a)),
                Operation::Product(a, b) => algebra.multiply(&of(*a), &of(*b)),
                Operation::Reciprocal(a) => {
                    let one = algebra.one();
                    algebra.divide(&one, &of(*a))?
                }
                Operation::Function(function, a) => algebra.apply(*function, &of(*a))?,
                Operation::Power(a, b) => algebra.power(&of(*a), &of(*b))?,
                Operation::Binary(function, a, b) => {
                    algebra.apply_two(*function, &of(*a), &of(*b))?
                }
                Operation::Lookup(lookup, point) => {
                    let point: Vec<_> = point.iter().map(|at| of(*at)).collect();
                    algebra.look_up(*lookup, &point)?
                }
                Operation::Kept(side, c, v) => algebra.kept(*side, &of(*c), &of(*v))?,
                Operation::StepSize(_) | Operation::Analytic(..) => {
                    return Err(AlgebraError::NoSeries);
                }
            };
            known[index] = Some(value);
        }
        let read = |term: &Term| known[term.node.index()].clone().expect("it was read");
        let scaled = |term: &Term| algebra.scale(&term.scale, &read(term));
        Ok(terms.iter().map(scaled).collect())
    }

    /// Which nodes terms are computed from, themselves included.
    pub(crate) fn read_by(&self, terms: &[Term]) -> Vec<bool> {
        let mut is_read = vec![false; self.len()];
        for term in terms {
            is_read[term.node.index()] = true;
        }
        for index in (0..self.len()).rev() {
            if !is_read[index] {
                continue;
            }
            for operand in self.operands(Node(index as u32)) {
                is_read[operand.index()] = true;
            }
        }
        is_read
    }

    fn import_node(
        &mut self,
        operation: &Operation,
        known: &[Option<Term>],
        inputs: &[Term],
    ) -> Result<Term, AlgebraError> {
        let of = |node: Node| {
            let code = known[node.index()].as_ref();
            code.expect("operands are written before their uses")
                .clone()
        };
        match operation {
            Operation::One => Ok(self.one()),
            Operation::Pi => Ok(self.pi()),
            Operation::Parameter(index) => Ok(self.parameter(*index as usize)),
            Operation::StepSize(which) => Ok(self.step_size(*which)),
            Operation::Input(index) => Ok(inputs[*index as usize].clone()),
            Operation::Sum(terms) => {
                let terms: Vec<(Rational, Term)> = terms
                    .iter()
                    .map(|(scale, node)| (scale.clone(), of(*node)))
                    .collect();
                Ok(self.combine(&terms))
            }
            Operation::Scale(scale, a) => {
                let scaled = self.scale(scale, &of(*a));
                // Long products of exact factors outgrow a double: a node that held its factor holds it again.
                let is_long = i64::try_from(scaled.scale.numerator()).is_err()
                    || i64::try_from(scaled.scale.denominator()).is_err();
                Ok(if is_long { self.whole(&scaled) } else { scaled })
            }
            Operation::Product(a, b) => Ok(self.multiply(&of(*a), &of(*b))),
            Operation::Reciprocal(a) => {
                let one = self.one();
                self.divide(&one, &of(*a))
            }
            Operation::Function(function, a) => self.apply(*function, &of(*a)),
            Operation::Analytic(function, order, a) => {
                Ok(self.apply_analytic(*function, *order, &of(*a)))
            }
            Operation::Power(a, b) => self.power(&of(*a), &of(*b)),
            Operation::Binary(function, a, b) => self.apply_two(*function, &of(*a), &of(*b)),
            Operation::Lookup(lookup, point) => {
                let point: Vec<Term> = point.iter().map(|at| of(*at)).collect();
                self.look_up(*lookup, &point)
            }
            Operation::Kept(side, c, v) => self.kept(*side, &of(*c), &of(*v)),
        }
    }
}
