//! The untruncated series of Karasev's α along p(h).

use leafwise_core::realization::{SourceRecursion, SourceSeries};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::DifferentialAlgebra;

use crate::curve::KarasevCurve;

/// α(x, p(h)) = Σ hᵏ αₖ for p(h) = Σ_{k≥1} pₖ hᵏ at ε = 1.
#[derive(Clone, Debug)]
pub struct KarasevSeries {
    system: SystemFormulas,
}

impl KarasevSeries {
    /// The series for a system's tensor.
    pub fn new(system: SystemFormulas) -> Self {
        Self { system }
    }

    /// The same from its start in either algebra, as realizations offer it.
    pub fn source(&self) -> SourceSeries<'_> {
        SourceSeries {
            in_ring: Box::new(|ring, coordinates| self.start(ring, coordinates)),
            in_graph: Box::new(|graph, coordinates| self.start(graph, coordinates)),
        }
    }

    fn start<A: DifferentialAlgebra>(
        &self,
        algebra: &mut A,
        coordinates: &[usize],
    ) -> Result<SourceRecursion<A>, BuildError> {
        let x = coordinates.iter().map(|at| algebra.coordinate(*at));
        let x: Vec<A::Element> = x.collect();
        let mut curve = KarasevCurve::new(&self.system, &x)?;
        Ok(Box::new(move |algebra, p| {
            curve.push(algebra, &p)?;
            Ok(curve.source(algebra, curve.order()))
        }))
    }
}
