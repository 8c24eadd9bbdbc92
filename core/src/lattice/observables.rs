//! Sums over sites: energy, Casimirs, and what else a run watches.

use std::ops::Range;

use leafwise_expression::{Expression, Graph, Term};

use super::program::LatticeEvaluator;
use super::sites::SiteNumbers;
use super::source::LatticeSource;
pub use super::source::SiteDensity;
use crate::error::BuildError;
use crate::observe::Observe;

/// Evaluates sums over sites in O(N), with a compensated sum in the order of the sites.
#[derive(Clone, Debug)]
pub struct LatticeObservables {
    densities: SiteNumbers,
    evaluator: LatticeEvaluator,
    constants: Vec<f64>,
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
        let mut constants = Vec::new();
        let mut of_site = |proxy: &_, site: usize, graph: &mut Graph, x: &[Term]| {
            let mut densities = source.densities(proxy, site)?;
            densities.truncate(selection.end);
            densities.drain(..selection.start.min(densities.len()));
            if site == 0 {
                constants = densities
                    .iter()
                    .map(|d| d.constant.evaluate(&[], parameters))
                    .collect();
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
            evaluator: densities.evaluator(parameters),
            densities,
            constants,
        })
    }
}

/// A density as code.
pub(super) fn code(
    graph: &mut Graph,
    density: &Expression,
    x: &[Term],
) -> Result<Term, BuildError> {
    Ok(density.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?)
}

impl Observe for LatticeObservables {
    fn observables(&self) -> usize {
        self.constants.len()
    }

    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        let state = state.iter().copied();
        self.densities.evaluate(&mut self.evaluator, state);
        for (number, (value, constant)) in values.iter_mut().zip(&self.constants).enumerate() {
            *value = compensated_sum(*constant, self.densities.of_sites(&self.evaluator, number));
        }
    }
}

/// Neumaier's sum: the result does not depend on how sites are grouped.
fn compensated_sum(start: f64, terms: &[f64]) -> f64 {
    let (mut sum, mut low) = (start, 0.0);
    for &term in terms {
        let next = sum + term;
        low += if sum.abs() >= term.abs() {
            (sum - next) + term
        } else {
            (term - next) + sum
        };
        sum = next;
    }
    sum + low
}
