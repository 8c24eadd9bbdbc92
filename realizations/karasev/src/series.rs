//! The untruncated series of Karasev's α along p(h), in the exact ring.

use leafwise_core::realization::{SourceRecursion, SourceSeries};
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::{Polynomial, Ring};

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
    fn start(&self, ring: &mut Ring) -> Result<Box<dyn SourceRecursion>, BuildError> {
        let x: Vec<Polynomial> = (0..self.system.dimension())
            .map(|i| ring.variable(i))
            .collect();
        Ok(Box::new(Recursion {
            curve: KarasevCurve::new(&self.system, &x)?,
        }))
    }
}

struct Recursion {
    curve: KarasevCurve<Polynomial>,
}

impl SourceRecursion for Recursion {
    fn push(&mut self, ring: &mut Ring, p: Vec<Polynomial>) -> Result<Vec<Polynomial>, BuildError> {
        self.curve.push(ring, &p)?;
        Ok(self.curve.source(ring, self.curve.order()))
    }
}
