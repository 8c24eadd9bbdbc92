//! α(x, p(h)) = x − ½ Π p(h), coefficient by coefficient.

use leafwise_core::realization::{SourceRecursion, SourceSeriesIn};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{DifferentialAlgebra, Rational};

/// αₖ = −½ Π pₖ.
#[derive(Clone, Debug)]
pub struct ConstantSeries {
    system: SystemFormulas,
}

impl ConstantSeries {
    /// The series for a system whose tensor is constant.
    pub(crate) fn new(system: SystemFormulas) -> Self {
        Self { system }
    }
}

impl<A: DifferentialAlgebra> SourceSeriesIn<A> for ConstantSeries {
    fn start(&self, algebra: &mut A) -> Result<Box<dyn SourceRecursion<A>>, BuildError> {
        let x = (0..self.system.dimension()).map(|i| algebra.coordinate(i));
        Ok(Box::new(Recursion {
            x: x.collect(),
            system: self.system.clone(),
        }))
    }
}

struct Recursion<E> {
    system: SystemFormulas,
    x: Vec<E>,
}

impl<A: DifferentialAlgebra> SourceRecursion<A> for Recursion<A::Element> {
    fn push(&mut self, algebra: &mut A, p: Vec<A::Element>) -> Result<Vec<A::Element>, BuildError> {
        let rows = self.system.apply_tensor(algebra, &self.x, &p)?;
        let factor = Rational::new(-1, 2);
        Ok(rows.iter().map(|row| algebra.scale(&factor, row)).collect())
    }
}
