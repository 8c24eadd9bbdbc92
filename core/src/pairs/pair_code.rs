//! The code of one pair.

use leafwise_expression::{Arithmetic, Graph, Kernel, Side, Term};

use super::BodyShape;
use super::function::{BodyFunction, BodySum, Weighted, families_of, is_symmetric};
use super::matrix::{PairEntry, PairMatrix};
use crate::error::BuildError;

/// Row of numbers that the code of a pair reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PairRow {
    /// A coordinate of site i, and of site j.
    First(usize),
    Second(usize),
    /// An entry of a matrix.
    Entry(usize, PairEntry),
    /// A weight of a sum.
    Weight(usize),
    /// 1 where the pair counts, else 0.
    Mask,
    /// A sum over j at site i, and one over i at site j.
    FirstSum(usize),
    SecondSum(usize),
}

/// The code that adds what one pair gives to the sums at its sites.
#[derive(Clone, Debug)]
pub(super) struct PairCode {
    pub(super) kernel: Kernel,
    pub(super) inputs: Vec<PairRow>,
    pub(super) outputs: Vec<PairRow>,
    /// Whether i and j may change places.
    pub(super) is_symmetric: bool,
    /// The matrices whose entries it reads.
    pub(super) matrices: Vec<PairMatrix>,
}

impl PairCode {
    /// Code of the gradient by these families: ∂p/∂x_i is added at site i, ∂p/∂x_j at site j. `None` where no pair
    /// gives anything.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    pub(super) fn of_gradient(
        (function, weighted): (&BodyFunction, &Weighted<'_>),
        shape: &BodyShape,
        by: &[usize],
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let pairs = || function.sums.iter().map(|sum| &sum.pair);
        let named = families_of(pairs(), shape);
        let mut inputs = PairInputs::new(shape, function.sums.len());
        let total = weighted.total(
            &mut inputs.graph,
            |sum| &sum.pair,
            &inputs.coordinates,
            &inputs.weights,
        )?;
        let is_symmetric = pairs().all(|pair| is_symmetric(pair, shape));
        let counted = match is_symmetric {
            true => inputs.graph.multiply(&total, &inputs.mask),
            false => total,
        };
        let slopes = inputs.graph.gradient(&counted, 2 * shape.families)?;
        let mut terms = Vec::new();
        for family in by.iter().filter(|family| named.contains(family)) {
            for (slope, row) in [
                (&slopes[*family], PairRow::FirstSum(*family)),
                (
                    &slopes[shape.families + family],
                    PairRow::SecondSum(*family),
                ),
            ] {
                terms.push((slope.clone(), row));
            }
        }
        inputs.compile(terms, is_symmetric, parameters)
    }

    /// Code of the sums themselves: p_k is added at site i to sum k. `None` where no pair gives anything.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(super) fn of_sums(
        sums: &[&BodySum],
        shape: &BodyShape,
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let mut pairs = sums.iter().map(|sum| &sum.pair);
        let is_symmetric = pairs.all(|pair| is_symmetric(pair, shape));
        let mut inputs = PairInputs::new(shape, 0);
        let mut terms = Vec::new();
        for (k, sum) in sums.iter().enumerate() {
            let coordinates = &inputs.coordinates;
            let graph = &mut inputs.graph;
            let value = (sum.pair).evaluate_in(graph, &mut |_, at| Ok(coordinates[at].clone()))?;
            let counted = match is_symmetric {
                true => graph.multiply(&value, &inputs.mask),
                false => value,
            };
            terms.push((counted, PairRow::FirstSum(k)));
        }
        inputs.compile(terms, is_symmetric, parameters)
    }

    /// The rows that it reads or writes, each once, in a fixed order.
    pub(super) fn rows(&self) -> Vec<PairRow> {
        let mut rows = self.inputs.clone();
        rows.extend(&self.outputs);
        rows.push(PairRow::Mask);
        let mut own = Vec::new();
        for row in rows {
            if !own.contains(&row) {
                own.push(row);
            }
        }
        own
    }
}

/// The inputs of a graph of one pair, each with its row.
struct PairInputs {
    graph: Graph,
    rows: Vec<PairRow>,
    coordinates: Vec<Term>,
    weights: Vec<Term>,
    mask: Term,
    matrices: Vec<PairMatrix>,
}

impl PairInputs {
    fn new(shape: &BodyShape, weights: usize) -> Self {
        let mut graph = Graph::compilable();
        let families = 0..shape.families;
        let mut rows: Vec<PairRow> = families.clone().map(PairRow::First).collect();
        rows.extend(families.map(PairRow::Second));
        for matrix in 0..shape.matrices.len() {
            let entries = (0..PairEntry::COUNT).map(PairEntry::numbered);
            rows.extend(entries.map(|entry| PairRow::Entry(matrix, entry)));
        }
        rows.extend((0..weights).map(PairRow::Weight));
        rows.push(PairRow::Mask);
        let mut terms: Vec<Term> = (0..rows.len()).map(|at| graph.input(at)).collect();
        let mask = terms.pop().unwrap_or_else(|| graph.input(0));
        let weights = terms.split_off(shape.variables());
        let own = (0..terms.len()).map(|at| terms[shape.first_equal(at)].clone());
        Self {
            graph,
            rows,
            coordinates: own.collect(),
            weights,
            mask,
            matrices: shape.matrices.clone(),
        }
    }

    /// Code that adds these terms to sums. What does not count is a pair that does, unless i and j may not change places:
    /// then it may be no number, and is kept out.
    fn compile(
        mut self,
        terms: Vec<(Term, PairRow)>,
        is_symmetric: bool,
        parameters: usize,
    ) -> Result<Option<PairCode>, BuildError> {
        let given = terms.into_iter().filter(|(term, _)| !term.scale.is_zero());
        let (mut sums, mut outputs) = (Vec::new(), Vec::new());
        for (term, row) in given {
            let term = match is_symmetric {
                true => term,
                false => self.graph.kept(Side::Above, &self.mask, &term)?,
            };
            let before = self.graph.input(self.rows.len());
            self.rows.push(row);
            sums.push(self.graph.add(&before, &term));
            outputs.push(row);
        }
        self.graph.unless_refused(())?;
        if sums.is_empty() {
            return Ok(None);
        }
        let (kernel, used) = Kernel::compile_used(&self.graph, &sums, parameters);
        Ok(Some(PairCode {
            kernel,
            inputs: used.into_iter().map(|input| self.rows[input]).collect(),
            outputs,
            is_symmetric,
            matrices: self.matrices,
        }))
    }
}
