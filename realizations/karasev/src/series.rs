//! The untruncated series of Karasev's α along p(h).

use leafwise_core::realization::{SourceRecursion, SourceSeries};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{DifferentialAlgebra, Graph, Ring};

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
}

impl SourceSeries for KarasevSeries {
    fn in_ring(
        &self,
        ring: &mut Ring,
        coordinates: &[usize],
    ) -> Result<Box<dyn SourceRecursion<Ring>>, BuildError> {
        Ok(Box::new(Recursion::start(&self.system, ring, coordinates)?))
    }

    fn in_graph(
        &self,
        graph: &mut Graph,
        coordinates: &[usize],
    ) -> Result<Box<dyn SourceRecursion<Graph>>, BuildError> {
        Ok(Box::new(Recursion::start(
            &self.system,
            graph,
            coordinates,
        )?))
    }
}

struct Recursion<E> {
    curve: KarasevCurve<E>,
}

impl<E: Clone + std::fmt::Debug> Recursion<E> {
    fn start<A: DifferentialAlgebra<Element = E>>(
        system: &SystemFormulas,
        algebra: &mut A,
        coordinates: &[usize],
    ) -> Result<Self, BuildError> {
        let x = coordinates.iter().map(|at| algebra.coordinate(*at));
        let x: Vec<E> = x.collect();
        Ok(Self {
            curve: KarasevCurve::new(system, &x)?,
        })
    }
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        self.curve.push(algebra, &p)?;
        Ok(self.curve.source(algebra, self.curve.order()))
    }
}
