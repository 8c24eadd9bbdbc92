//! The untruncated series of Karasev's α along p(h).

use leafwise_core::realization::{SourceRecursion, SourceSeriesIn};
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
}

impl<A: DifferentialAlgebra> SourceSeriesIn<A> for KarasevSeries {
    fn start(&self, algebra: &mut A) -> Result<Box<dyn SourceRecursion<A>>, BuildError> {
        let x: Vec<A::Element> = (0..self.system.dimension())
            .map(|i| algebra.coordinate(i))
            .collect();
        Ok(Box::new(Recursion {
            curve: KarasevCurve::new(&self.system, &x)?,
        }))
    }
}

struct Recursion<E> {
    curve: KarasevCurve<E>,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        self.curve.push(algebra, &p)?;
        Ok(self.curve.source(algebra, self.curve.order()))
    }
}
