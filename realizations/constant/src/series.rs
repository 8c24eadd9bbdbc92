//! α(x, p(h)) = x − ½ Π p(h), coefficient by coefficient.

use leafwise_core::realization::{SourceRecursion, SourceSeries};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};

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

impl SourceSeries for ConstantSeries {
    fn start(&self, ring: &mut Ring) -> Result<Box<dyn SourceRecursion>, BuildError> {
        let x = (0..self.system.dimension()).map(|i| ring.variable(i));
        Ok(Box::new(Recursion {
            x: x.collect(),
            system: self.system.clone(),
        }))
    }
}

struct Recursion {
    system: SystemFormulas,
    x: Vec<Polynomial>,
}

impl SourceRecursion for Recursion {
    fn push(&mut self, ring: &mut Ring, p: Vec<Polynomial>) -> Result<Vec<Polynomial>, BuildError> {
        let rows = self.system.apply_tensor(ring, &self.x, &p)?;
        let factor = Rational::new(-1, 2);
        Ok(rows.iter().map(|row| ring.scale(&factor, row)).collect())
    }
}
