//! The code of one pair.

use leafwise_expression::{Arithmetic, Graph, Kernel, Side, Term};

use super::BodyShape;
use super::curve::CurveOfSites;
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
    /// gives anything. Along a curve they are its coefficients from an order on.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    pub(super) fn of_gradient(
        (function, weighted): (&BodyFunction, &Weighted<'_>),
        (curve, from): (&CurveOfSites, usize),
        by: &[usize],
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let shape = &curve.shape;
        let pairs = || function.sums.iter().map(|sum| &sum.pair);
        let named = families_of(pairs(), shape);
        let is_symmetric = pairs().all(|pair| is_symmetric(pair, shape));
        let mut inputs = PairInputs::new(curve, weighted.of_sums().len());
        let slopes = inputs.coefficients(curve, |graph, inputs| {
            let (inputs, mask) = inputs.split_at(inputs.len() - 1);
            slopes_of_a_pair(
                weighted,
                shape,
                graph,
                inputs,
                is_symmetric.then(|| &mask[0]),
            )
        })?;
        let mut terms = Vec::new();
        for (order, slopes) in slopes.iter().enumerate().skip(from) {
            for family in by.iter().filter(|family| named.contains(family)) {
                let row = order * shape.families + family;
                let second = slopes[shape.families + family].clone();
                terms.push((slopes[*family].clone(), PairRow::FirstSum(row)));
                terms.push((second, PairRow::SecondSum(row)));
            }
        }
        inputs.compile(terms, is_symmetric, parameters)
    }

    /// Code of the sums themselves: p_k is added at site i to sum k. `None` where no pair gives anything. Along a curve
    /// they are its coefficients, order after order.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(super) fn of_sums(
        sums: &[&BodySum],
        curve: &CurveOfSites,
        parameters: usize,
    ) -> Result<Option<Self>, BuildError> {
        let mut pairs = sums.iter().map(|sum| &sum.pair);
        let is_symmetric = pairs.all(|pair| is_symmetric(pair, &curve.shape));
        let mut inputs = PairInputs::new(curve, 0);
        let values = inputs.coefficients(curve, |graph, inputs| {
            let (coordinates, mask) = inputs.split_at(inputs.len() - 1);
            let counted = |sum: &&BodySum| {
                let variable = &mut |_: &mut _, at: usize| Ok(coordinates[at].clone());
                let value = sum.pair.evaluate_in(graph, variable)?;
                Ok(match is_symmetric {
                    true => graph.multiply(&value, &mask[0]),
                    false => value,
                })
            };
            sums.iter().map(counted).collect()
        })?;
        let values = values.concat().into_iter().enumerate();
        let terms = values.map(|(k, value)| (value, PairRow::FirstSum(k)));
        inputs.compile(terms.collect(), is_symmetric, parameters)
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

/// Slopes of Σ_k ∂F/∂S_k p_k of one pair, by the coordinates of site i and then of site j. Inputs are the variables of a
/// pair and then the weights of sums. A mask multiplies the sum.
///
/// # Errors
/// [`BuildError::Algebra`] where a formula or derivative has no code.
pub(super) fn slopes_of_a_pair(
    weighted: &Weighted<'_>,
    shape: &BodyShape,
    graph: &mut Graph,
    inputs: &[Term],
    mask: Option<&Term>,
) -> Result<Vec<Term>, BuildError> {
    let (coordinates, weights) = inputs.split_at(shape.variables());
    let total = weighted.total(graph, |sum| &sum.pair, coordinates, weights)?;
    let counted = match mask {
        Some(mask) => graph.multiply(&total, mask),
        None => total,
    };
    Ok(graph.gradient(&counted, 2 * shape.families)?)
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
    /// Those along a curve, with so many weights of each order.
    fn new(curve: &CurveOfSites, weights: usize) -> Self {
        let shape = curve.whole();
        let mut graph = Graph::compilable();
        let families = 0..shape.families;
        let mut rows: Vec<PairRow> = families.clone().map(PairRow::First).collect();
        rows.extend(families.map(PairRow::Second));
        for matrix in 0..shape.matrices.len() {
            let entries = (0..PairEntry::COUNT).map(PairEntry::numbered);
            rows.extend(entries.map(|entry| PairRow::Entry(matrix, entry)));
        }
        rows.extend((0..(curve.order + 1) * weights).map(PairRow::Weight));
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
            matrices: shape.matrices,
        }
    }

    /// The coefficients along a curve of code that `write` writes of the variables of a pair, the weights and the mask, one
    /// after the other.
    fn coefficients(
        &mut self,
        curve: &CurveOfSites,
        write: impl FnOnce(&mut Graph, &[Term]) -> Result<Vec<Term>, BuildError>,
    ) -> Result<Vec<Vec<Term>>, BuildError> {
        let (graph, whole) = (&mut self.graph, curve.whole().families);
        let (coordinates, entries) = self.coordinates.split_at(2 * whole);
        let mut inputs = curve.coordinates(graph, &coordinates[..whole]);
        let second = curve.coordinates(graph, &coordinates[whole..]);
        for (own, second) in inputs.iter_mut().zip(second) {
            own.extend(second);
        }
        curve.add_resting(graph, &mut inputs, entries);
        let count = self.weights.len() / (curve.order + 1);
        for (order, own) in inputs.iter_mut().enumerate() {
            own.extend_from_slice(&self.weights[order * count..][..count]);
        }
        curve.add_resting(graph, &mut inputs, std::slice::from_ref(&self.mask));
        curve.coefficients(graph, &inputs, write)
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
