//! Directions within a symplectic leaf.

use super::PoissonSystem;
use super::tensor_matrix::TensorMatrix;
use crate::error::BuildError;
use crate::observer::Observer;
use crate::random::Random;

/// Vectors Π(x)a_1, …, Π(x)a_k at a state x, d numbers each: tangent to the symplectic leaf through x.
///
/// A Poisson map carries the leaf's tangent space at x into that at Φ(x), since DΦ Π(x) DΦᵀ = Π(Φ(x)). The covectors a_i are
/// the same for every state: standard normal numbers of a fixed seed.
pub struct LeafDirections {
    tensor: TensorMatrix,
    /// a_1, …, a_k, d numbers each.
    covectors: Vec<f64>,
}

impl LeafDirections {
    /// So many directions at the values of the parameters.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry of the tensor has no code.
    pub fn new(
        system: &PoissonSystem,
        parameters: &[f64],
        count: usize,
    ) -> Result<Self, BuildError> {
        let dimension = system.dimension();
        // The first are the same however many there are.
        let covectors = (0..count as u64).flat_map(|i| {
            let mut random = Random::new(0, i, 0);
            (0..dimension).map(move |_| random.normal())
        });
        Ok(Self {
            tensor: TensorMatrix::new(system, parameters)?,
            covectors: covectors.collect(),
        })
    }

    /// The columns of Π(x), d directions.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an entry of the tensor has no code.
    pub fn columns(system: &PoissonSystem, parameters: &[f64]) -> Result<Self, BuildError> {
        let dimension = system.dimension();
        let mut covectors = vec![0.0; dimension * dimension];
        (0..dimension).for_each(|i| covectors[i * dimension + i] = 1.0);
        Ok(Self {
            tensor: TensorMatrix::new(system, parameters)?,
            covectors,
        })
    }

    /// Writes the vectors one after the other; not numbers where the tensor has no value.
    fn evaluate(&mut self, state: &[f64], values: &mut [f64]) {
        let written = self.tensor.times(state, &self.covectors, values);
        if written.is_err() {
            values.fill(f64::NAN);
        }
    }
}

impl From<LeafDirections> for Observer {
    fn from(mut own: LeafDirections) -> Self {
        Self::new(own.covectors.len(), move |state, values| {
            own.evaluate(state, values);
        })
    }
}
