//! Where inputs and outputs of a kernel stand beside a place of an array.

use std::ops::Range;

use super::code::Code;

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

    /// Whether all that stands at these distances from the places is in an array of that length, with one place at
    /// least. Outputs must stand where nothing else does but for inputs of the same place.
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
