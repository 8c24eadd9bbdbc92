//! Kernels along an array: inputs and outputs stand beside a place that moves.

use std::ops::Range;
use std::sync::Arc;

use super::code::Code;
use super::compile::Kernel;
use super::execution::Compiled;
use super::workspace::Workspace;

/// How far from a place of an array each input and each output of a kernel stands.
#[derive(Clone, Debug)]
pub(super) struct Distances {
    pub(super) inputs: Vec<i32>,
    pub(super) outputs: Vec<i32>,
    /// The smallest and the largest of them all.
    ends: [isize; 2],
    /// At so many places in a row each output stands where nothing else does, but for inputs of the same place.
    apart: usize,
}

/// The longest distance: in bytes it has 31 bits, with room for a few registers of numbers.
const FARTHEST: isize = 1 << 27;

impl Distances {
    /// `None` where one is too long, or an output replaces what another one is.
    pub(super) fn new(code: &Code, inputs: &[isize], outputs: &[isize]) -> Option<Self> {
        let all = || inputs.iter().chain(outputs).copied();
        let ends = [all().min()?, all().max()?];
        if ends[0] < -FARTHEST || ends[1] > FARTHEST {
            return None;
        }
        let mut apart = usize::MAX;
        for (at, output) in outputs.iter().enumerate() {
            let others = inputs.iter().filter(|input| *input != output);
            for other in others.chain(&outputs[..at]) {
                apart = apart.min(output.abs_diff(*other));
            }
        }
        let short = |distances: &[isize]| distances.iter().map(|d| *d as i32).collect();
        let distances = Self {
            inputs: short(inputs),
            outputs: short(outputs),
            ends,
            apart,
        };
        (apart > 0 && !distances.replace_outputs(code)).then_some(distances)
    }

    /// Whether all that stands at these distances from the places, of which there is one at least, is in an array of that
    /// length, outputs where nothing else does but for inputs of the same place.
    pub(super) fn fit(&self, places: &Range<usize>, length: usize) -> bool {
        let Range { start, end } = *places;
        let [lowest, highest] = self.ends;
        let is_before_end = |at: usize| at < length;
        start < end
            && end <= length
            && end - start <= self.apart
            && start.checked_add_signed(lowest).is_some()
            && (end - 1)
                .checked_add_signed(highest)
                .is_some_and(is_before_end)
    }

    /// Whether an output is an input that another output replaces.
    fn replace_outputs(&self, code: &Code) -> bool {
        code.outputs.iter().zip(&self.outputs).any(|(slot, own)| {
            let input = self.inputs.get(*slot as usize);
            input.is_some_and(|input| input != own && self.outputs.contains(input))
        })
    }
}

impl Kernel {
    /// The same kernel with inputs and outputs in an array, so far from a place that moves along it.
    ///
    /// # Panics
    /// When there is not one distance an input and one an output.
    pub fn at_distances(mut self, inputs: &[isize], outputs: &[isize]) -> Self {
        assert_eq!(
            (inputs.len(), outputs.len()),
            (self.inputs, self.outputs()),
            "one distance an input and one an output"
        );
        let distances = Distances::new(&self.step_code, inputs, outputs);
        self.along = distances.map(|distances| Arc::new(Compiled::along(distances)));
        self
    }

    /// Runs the step kernel at places of an array one after the other, from the first of them on: reads the inputs at their
    /// distances from the place, then writes the outputs at theirs. Returns at how many places it did, a multiple of the lanes of
    /// a register: 0 unless the workspace runs machine code, whose coefficients are the same in all lanes.
    ///
    /// # Panics
    /// When an input or output would not be in the array, or would stand, at one of the places, where an output stands
    /// at another one.
    pub fn evaluate_along(
        &self,
        workspace: &mut Workspace,
        array: &mut [f64],
        places: Range<usize>,
    ) -> usize {
        let Some(along) = self.along.as_ref().filter(|_| !places.is_empty()) else {
            return 0;
        };
        assert!(
            along.fits(&places, array.len()),
            "inputs and outputs in the array, outputs where nothing else is"
        );
        let reached = workspace.run_along(self, along, array, places.clone());
        reached.map_or(0, |reached| reached - places.start)
    }
}
