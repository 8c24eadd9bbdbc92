//! Sums over sites: energy, Casimirs, and what else a run watches.

use std::ops::Range;

use leafwise_expression::{Expression, Graph, Term};

use super::method::LatticeSource;
use super::program::{LatticeProgram, LatticeWorker, Proxy};
use super::stages::{Field, StageBuilder};
use crate::error::BuildError;
use crate::solver::Observe;

/// f = constant + Σ_i site(i): one site's share.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteDensity {
    /// What does not depend on the state.
    pub constant: Expression,
    /// The terms at the site asked for.
    pub site: Expression,
}

/// The longest reach of a density.
const REACH: usize = 8;

/// Evaluates sums over sites in O(N), with a compensated sum in the order of the sites.
#[derive(Clone, Debug)]
pub struct LatticeObservables {
    program: LatticeProgram,
    worker: LatticeWorker,
    state: Field,
    densities: Vec<Field>,
    constants: Vec<f64>,
    sites: usize,
}

impl LatticeObservables {
    /// Compiles the densities of `source` whose places lie in `selection`.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] when a density reaches further than 8 sites, and those of
    /// [`LatticeSource::densities`].
    pub fn new(
        source: &dyn LatticeSource,
        parameters: &[f64],
        selection: Range<usize>,
    ) -> Result<Self, BuildError> {
        let geometry = source.geometry();
        let shorter = geometry
            .families
            .iter()
            .map(|f| geometry.length() - f.1)
            .max()
            .unwrap_or(0);
        let width = REACH + shorter;
        let length = 2 * width + 3;
        let (proxy, width) = if geometry.length() <= length {
            (geometry.clone(), 0)
        } else {
            (geometry.resized(length), width)
        };
        let mut builder = StageBuilder::new(proxy.dimension());
        let (state, x) = builder.unwritten();
        let mut columns: Vec<Vec<Term>> = Vec::new();
        let mut constants = Vec::new();
        for site in 0..proxy.length() {
            let mut densities = source.densities(&proxy, site)?;
            densities.truncate(selection.end);
            densities.drain(..selection.start.min(densities.len()));
            columns.resize(densities.len(), Vec::new());
            if site == 0 {
                constants = densities
                    .iter()
                    .map(|d| d.constant.evaluate(&[], parameters))
                    .collect();
            }
            for (column, density) in columns.iter_mut().zip(&densities) {
                column.push(code(&mut builder.graph, &density.site, &x)?);
            }
        }
        // A density stands in the place of the longest family, one number a site.
        let longest = proxy
            .families
            .iter()
            .position(|f| f.1 == proxy.length())
            .unwrap_or(0);
        let start = proxy.offsets()[longest];
        let densities = columns
            .into_iter()
            .map(|column| {
                let mut values = x.clone();
                values[start..start + column.len()].clone_from_slice(&column);
                builder.output(values)
            })
            .collect();
        builder.finish_stage();
        let program = LatticeProgram::compile(
            geometry,
            Proxy {
                geometry: &proxy,
                width,
            },
            &builder,
            parameters.len(),
        )?;
        let worker = program.worker(parameters, 1.0, 1.0);
        Ok(Self {
            program,
            worker,
            state,
            densities,
            constants,
            sites: geometry.length(),
        })
    }
}

fn code(graph: &mut Graph, density: &Expression, x: &[Term]) -> Result<Term, BuildError> {
    Ok(density.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?)
}

impl Observe for LatticeObservables {
    fn observables(&self) -> usize {
        self.densities.len()
    }

    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        self.worker.field_mut(self.state).copy_from_slice(state);
        self.program.run(&mut self.worker);
        let start = self.program.longest_start();
        for ((value, field), constant) in
            values.iter_mut().zip(&self.densities).zip(&self.constants)
        {
            let terms = &self.worker.field(*field)[start..start + self.sites];
            *value = compensated_sum(*constant, terms);
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
