//! Sums over sites: energy, Casimirs, and what else a run watches.

use std::ops::Range;
use std::sync::Arc;

use leafwise_expression::{Expression, Graph, Term};

use super::program::LatticeEvaluator;
use super::sites::SiteNumbers;
use super::source::LatticeSource;
pub use super::source::SiteDensity;
use crate::compensation::two_sum;
use crate::error::BuildError;

/// Evaluates sums over sites in O(N), with a compensated sum in the order of the sites.
#[derive(Clone, Debug)]
pub struct LatticeObservables {
    densities: Arc<SiteNumbers>,
    parameters: Vec<f64>,
    room: Room,
    constants: Vec<f64>,
    /// The constants as functions of the parameters.
    formulas: Vec<Expression>,
}

/// Memory of evaluations: made by the first one, since most copies of observables evaluate nothing and a long lattice's
/// room takes as much as two of its states.
#[derive(Debug, Default)]
struct Room(Option<LatticeEvaluator>);

impl Clone for Room {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl LatticeObservables {
    /// Compiles the densities of `source` whose places lie in `selection`.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] when a density looks too far; those of [`LatticeSource::densities`] and
    /// [`LatticeSource::reach`].
    pub fn new(
        source: &dyn LatticeSource,
        parameters: &[f64],
        selection: Range<usize>,
    ) -> Result<Self, BuildError> {
        let mut formulas = Vec::new();
        let mut of_site = |proxy: &_, site: usize, graph: &mut Graph, x: &[Term]| {
            let mut densities = source.densities(proxy, site)?;
            densities.truncate(selection.end);
            densities.drain(..selection.start.min(densities.len()));
            if site == 0 {
                formulas = densities.iter().map(|d| d.constant.clone()).collect();
            }
            let mut terms = densities.iter();
            terms.try_fold(Vec::new(), |mut terms, density| {
                terms.push(code(graph, &density.site, x)?);
                Ok(terms)
            })
        };
        let densities = SiteNumbers::compile(
            (source.geometry(), source.reach()?.terms),
            parameters.len(),
            &mut of_site,
        )?;
        Ok(Self {
            densities: Arc::new(densities),
            parameters: parameters.to_vec(),
            room: Room::default(),
            constants: values(&formulas, parameters),
            formulas,
        })
    }

    /// The same at other values of the parameters.
    pub fn at(&self, parameters: &[f64]) -> Self {
        Self {
            densities: Arc::clone(&self.densities),
            parameters: parameters.to_vec(),
            room: Room::default(),
            constants: values(&self.formulas, parameters),
            formulas: self.formulas.clone(),
        }
    }
}

/// Functions of the parameters alone at these values.
fn values(formulas: &[Expression], parameters: &[f64]) -> Vec<f64> {
    let value = |formula: &Expression| formula.evaluate(&[], parameters);
    formulas.iter().map(value).collect()
}

/// A density as code.
pub(super) fn code(
    graph: &mut Graph,
    density: &Expression,
    x: &[Term],
) -> Result<Term, BuildError> {
    Ok(density.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?)
}

impl LatticeObservables {
    /// How many.
    pub fn observables(&self) -> usize {
        self.constants.len()
    }

    /// Writes their values at a state.
    pub fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        let Room(room) = &mut self.room;
        let evaluator = room.get_or_insert_with(|| self.densities.evaluator(&self.parameters));
        self.densities.evaluate(evaluator, state.iter().copied());
        let mut number = 0;
        for (values, constants) in values
            .chunks_mut(TOGETHER)
            .zip(self.constants.chunks(TOGETHER))
        {
            let mut sums = [Compensated::default(); TOGETHER];
            let terms: [&[f64]; TOGETHER] = std::array::from_fn(|at| match at < constants.len() {
                true => self.densities.of_sites(evaluator, number + at),
                false => self.densities.of_sites(evaluator, number),
            });
            for (sum, constant) in sums.iter_mut().zip(constants) {
                sum.high = *constant;
            }
            add(&mut sums, terms);
            for (value, sum) in values.iter_mut().zip(sums) {
                *value = sum.high + sum.low;
            }
            number += constants.len();
        }
    }
}

/// Sums that are formed together: each waits for its own last addition, and meanwhile the others go on.
const TOGETHER: usize = 4;

/// Neumaier's sum: the result does not depend on how sites are grouped.
#[derive(Clone, Copy, Default)]
struct Compensated {
    high: f64,
    low: f64,
}

/// Adds the terms of every sum in the order of the sites.
fn add(sums: &mut [Compensated; TOGETHER], terms: [&[f64]; TOGETHER]) {
    let sites = terms[0].len();
    let [a, b, c, d] = terms.map(|terms| &terms[..sites]);
    for site in 0..sites {
        for (sum, term) in sums.iter_mut().zip([a[site], b[site], c[site], d[site]]) {
            let (high, error) = two_sum(sum.high, term);
            sum.high = high;
            sum.low += error;
        }
    }
}
