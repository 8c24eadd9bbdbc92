//! Kernels along an array: inputs and outputs stand beside places that move.

use std::sync::Arc;

use super::compile::Kernel;
use super::distances::{Distance, Distances, Passes};
use super::execution::Compiled;
use super::workspace::Workspace;

impl Kernel {
    /// The same kernel with inputs and outputs in an array. Each has its distance from one of two places that move along
    /// the array side by side.
    ///
    /// # Panics
    /// When there is not one distance an input and one an output.
    pub fn at_distances(mut self, inputs: &[Distance], outputs: &[Distance]) -> Self {
        assert_eq!(
            (inputs.len(), outputs.len()),
            (self.inputs, self.outputs()),
            "one distance an input and one an output"
        );
        let distances = Distances::new(&self.step_code, inputs, outputs);
        self.along = distances.map(|distances| Arc::new(Compiled::along(distances)));
        self
    }

    /// Runs the step kernel at places of an array one after the other, pass after pass. At each it reads the inputs at
    /// their distances from the two places, then writes the outputs at theirs. Returns at how many places it did in each
    /// pass, a multiple of the lanes of a register. That is 0 unless the workspace runs machine code, whose coefficients
    /// are the same in all lanes.
    ///
    /// # Panics
    /// When an input or output would not be in the array. Also when one would stand, at one of the places of a pass,
    /// where an output stands at another one, unless they [may meet](Passes::may_meet).
    pub fn evaluate_along(
        &self,
        workspace: &mut Workspace,
        array: &mut [f64],
        passes: impl Into<Passes>,
    ) -> usize {
        let passes = passes.into();
        let Some(along) = self.along.as_ref().filter(|_| !passes.is_empty()) else {
            return 0;
        };
        assert!(
            along.fits(&passes, array.len()),
            "inputs and outputs in the array, outputs where nothing else is"
        );
        workspace.run_along(self, along, array, &passes)
    }
}
