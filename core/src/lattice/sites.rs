//! Numbers of every site of a lattice.

use leafwise_expression::syntax::AXES;
use leafwise_expression::{Arithmetic, Graph, Term};

use super::geometry::{LatticeGeometry, PerAxis, Proxy};
use super::locality::check_room;
use super::program::{LatticeEvaluator, LatticeProgram};
use super::stages::{Field, StageBuilder};
use crate::error::BuildError;

/// How far numbers may look at least along the axis of a chain.
const REACH: usize = 8;

/// Writes the numbers of a site of a lattice from the lattice's coordinates.
pub(super) type OfSite<'a> =
    dyn FnMut(&LatticeGeometry, usize, &mut Graph, &[Term]) -> Result<Vec<Term>, BuildError> + 'a;

/// The proxy on which numbers of sites that look so far are written, and its width.
///
/// # Errors
/// [`BuildError::NotLocal`] where it is too long.
pub(super) fn proxy_of_numbers(
    geometry: &LatticeGeometry,
    reach: PerAxis<usize>,
) -> Result<(LatticeGeometry, PerAxis<usize>), BuildError> {
    let least = if geometry.axes.len() == 1 { REACH } else { 1 };
    let proxy = geometry.proxy(reach.map(|reach| reach.max(least)));
    let (proxy, width) = proxy.unwrap_or_else(|| (geometry.clone(), [0; AXES]));
    check_room(&proxy, reach, 1)?;
    Ok((proxy, width))
}

/// Functions of the state around a site, evaluated at every site in O(N).
#[derive(Clone, Debug)]
pub(super) struct SiteNumbers {
    program: LatticeProgram,
    state: Field,
    numbers: Vec<Field>,
    sites: usize,
}

impl SiteNumbers {
    /// Compiles what `numbers` writes for each site of a proxy lattice from the proxy's coordinates, which
    /// are the graph's first inputs. They look at most `reach` sites away. Sites with fewer numbers than others have 1
    /// for those that they lack.
    ///
    /// # Errors
    /// [`BuildError::NotLocal`] when that is too far; those of `numbers`.
    pub(super) fn compile(
        (geometry, reach): (&LatticeGeometry, PerAxis<usize>),
        parameters: usize,
        numbers: &mut OfSite<'_>,
    ) -> Result<Self, BuildError> {
        let (proxy, width) = proxy_of_numbers(geometry, reach)?;
        let mut builder = StageBuilder::new(proxy.dimension());
        let (state, x) = builder.unwritten();
        let mut columns: Vec<Vec<Term>> = Vec::new();
        for site in 0..proxy.length() {
            let terms = numbers(&proxy, site, &mut builder.graph, &x)?;
            let one = builder.graph.one();
            while columns.len() < terms.len() {
                columns.push(vec![one.clone(); site]);
            }
            let terms = terms.into_iter().chain(std::iter::repeat(one));
            for (column, term) in columns.iter_mut().zip(terms) {
                column.push(term);
            }
        }
        // A number stands in the place of the longest family, one a site.
        let mut families = proxy.families.iter();
        let longest = families.position(|f| f.1 == proxy.length()).unwrap_or(0);
        let start = proxy.offsets()[longest];
        let columns = columns.into_iter().map(|column| {
            let mut values = x.clone();
            values[start..start + column.len()].clone_from_slice(&column);
            builder.output(values)
        });
        let numbers = columns.collect();
        builder.finish_stage();
        let proxy = Proxy {
            geometry: &proxy,
            width,
        };
        Ok(Self {
            program: LatticeProgram::compile(geometry, proxy, &builder, parameters)?,
            state,
            numbers,
            sites: geometry.length(),
        })
    }

    /// The number of sites.
    pub(super) fn sites(&self) -> usize {
        self.sites
    }

    /// Room to evaluate them.
    pub(super) fn evaluator(&self, parameters: &[f64]) -> LatticeEvaluator {
        self.program.evaluator(parameters, 1.0, 1.0)
    }

    /// Evaluates them at a state.
    pub(super) fn evaluate(
        &self,
        evaluator: &mut LatticeEvaluator,
        state: impl ExactSizeIterator<Item = f64>,
    ) {
        let field = evaluator.field_mut(self.state);
        field
            .iter_mut()
            .zip(state)
            .for_each(|(to, value)| *to = value);
        self.program.run(evaluator);
    }

    /// How many of them a site has.
    pub(super) fn count(&self) -> usize {
        self.numbers.len()
    }

    /// One of them at every site, after an evaluation.
    pub(super) fn of_sites<'a>(&self, evaluator: &'a LatticeEvaluator, number: usize) -> &'a [f64] {
        let start = self.program.longest_start();
        &evaluator.field(self.numbers[number])[start..][..self.sites]
    }
}
