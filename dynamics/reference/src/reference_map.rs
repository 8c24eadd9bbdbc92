//! A method as a step map.

use leafwise_core::solver::{Lanes, Trajectories, keeping_signs};
use leafwise_core::{MapProperties, StepMap, Stepper};
use nalgebra::DMatrix;

/// Makes a method's evaluator from parameters, a time step and a number of trajectories.
type Make = dyn Fn(&[f64], f64, usize) -> Box<dyn Trajectories> + Send + Sync;

/// A method as a [`StepMap`].
///
/// Its evaluators step from the doubles x: what the compensated state holds beyond them, half a unit in the last
/// place, changes an increment by less than its own rounding.
pub(crate) struct ReferenceMap {
    pub(crate) dimension: usize,
    pub(crate) properties: MapProperties,
    pub(crate) description: String,
    /// The most trajectories that one evaluator takes.
    pub(crate) together: usize,
    /// The coordinates of which a step that loses the sign is refused.
    pub(crate) kept_signs: Vec<usize>,
    pub(crate) make: Box<Make>,
}

impl StepMap for ReferenceMap {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let make = |parameters: &[f64], count| (self.make)(parameters, epsilon * h, count);
        let (most, d) = (self.together, self.dimension);
        let stepper = Box::new(Lanes::together(lanes, most, d, parameters, make));
        keeping_signs(stepper, &self.kept_signs)
    }
}

/// The entries of a matrix, row by row.
pub(crate) fn row_major(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}
