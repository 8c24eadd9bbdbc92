//! Where inputs and outputs of a kernel stand beside places of an array.

use std::ops::Range;

use super::code::Code;

/// Distance of a number of an array from one of the two places that move along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// From the first place.
    First(isize),
    /// From the second place.
    Second(isize),
}

impl Distance {
    pub(super) fn numbers(self) -> isize {
        match self {
            Self::First(numbers) | Self::Second(numbers) => numbers,
        }
    }

    fn is_second(self) -> bool {
        matches!(self, Self::Second(_))
    }
}

/// Passes of a kernel along an array. In each the first place takes the same places one after the other. The second place
/// is so far ahead of it, and from pass to pass farther by one stride.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Passes {
    /// Where the first place is, in each pass.
    pub places: Range<usize>,
    /// How far the second place is ahead of the first one in the first pass.
    pub ahead: usize,
    /// How much farther it is ahead in each next pass.
    pub stride: usize,
    /// The number of passes.
    pub count: usize,
    /// Whether an output may stand where an input of another place does. The kernel must leave such a number as it is.
    pub may_meet: bool,
}

/// One pass, where both places are one.
impl From<Range<usize>> for Passes {
    fn from(places: Range<usize>) -> Self {
        Self {
            places,
            ahead: 0,
            stride: 0,
            count: 1,
            may_meet: false,
        }
    }
}

impl Passes {
    /// Whether there is no place or no pass.
    pub(super) fn is_empty(&self) -> bool {
        self.places.is_empty() || self.count == 0
    }

    /// How far the second place is ahead in the last pass; `None` where that is no number.
    fn farthest(&self) -> Option<usize> {
        let strides = self.stride.checked_mul(self.count.checked_sub(1)?)?;
        self.ahead.checked_add(strides)
    }
}

/// How far from the places of an array each input and each output of a kernel stands.
#[derive(Clone, Debug)]
pub(super) struct Distances {
    pub(super) inputs: Vec<Distance>,
    pub(super) outputs: Vec<Distance>,
    /// The smallest and the largest from the first place, and from the second one, of each that there are.
    ends: [Option<[isize; 2]>; 2],
    /// At so many places in a row each output stands where nothing else does at the same distance from its own place, but
    /// for inputs of the same place.
    apart: usize,
    /// Where the second place is so far ahead of the first one, an output from one of them stands where something from the
    /// other one does. In order.
    meetings: Vec<isize>,
}

/// The longest distance: in bytes it has 31 bits, with room for a few registers of numbers.
const FARTHEST: isize = 1 << 27;

impl Distances {
    /// `None` where one is too long, or an output replaces what another one is.
    pub(super) fn new(code: &Code, inputs: &[Distance], outputs: &[Distance]) -> Option<Self> {
        let all = || inputs.iter().chain(outputs).copied();
        if all().any(|distance| distance.numbers().unsigned_abs() > FARTHEST.unsigned_abs()) {
            return None;
        }
        let ends = [false, true].map(|is_second| {
            let own = || all().filter(|distance| distance.is_second() == is_second);
            let own = || own().map(Distance::numbers);
            Some([own().min()?, own().max()?])
        });
        let mut apart = usize::MAX;
        let mut meetings = Vec::new();
        for (at, output) in outputs.iter().enumerate() {
            let others = inputs.iter().filter(|input| *input != output);
            for other in others.chain(&outputs[..at]) {
                match (output, other) {
                    (Distance::First(first), Distance::Second(second))
                    | (Distance::Second(second), Distance::First(first)) => {
                        meetings.push(first - second);
                    }
                    _ => apart = apart.min(output.numbers().abs_diff(other.numbers())),
                }
            }
        }
        meetings.sort_unstable();
        meetings.dedup();
        let distances = Self {
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            ends,
            apart,
            meetings,
        };
        (apart > 0 && !distances.replace_outputs(code)).then_some(distances)
    }

    /// Whether all that stands at these distances from the places is in an array of that length, with one place at
    /// least. In a pass outputs must stand where nothing else does but for inputs of the same place, unless they may meet.
    pub(super) fn fit(&self, passes: &Passes, length: usize) -> bool {
        let Range { start, end } = passes.places;
        let Some(farthest) = passes.farthest() else {
            return false;
        };
        let is_within = |from: usize, to: usize, place: usize| {
            self.ends[place].is_none_or(|[lowest, highest]| {
                let first = start.checked_add(from);
                let last = (end - 1).checked_add(to);
                let first = first.and_then(|first| first.checked_add_signed(lowest));
                let last = last.and_then(|last| last.checked_add_signed(highest));
                first.is_some() && last.is_some_and(|last| last < length)
            })
        };
        start < end
            && end <= length
            && is_within(0, 0, 0)
            && is_within(passes.ahead, farthest, 1)
            && (passes.may_meet
                || end - start <= self.apart && self.are_apart(passes.ahead, farthest, end - start))
    }

    /// Whether nothing from one place meets an output from the other, the second place so far ahead, at so many places.
    fn are_apart(&self, nearest: usize, farthest: usize, places: usize) -> bool {
        if self.meetings.is_empty() {
            return true;
        }
        let [nearest, farthest, places] = [nearest, farthest, places].map(|own| own as isize);
        let from = self
            .meetings
            .partition_point(|own| *own <= nearest - places);
        self.meetings
            .get(from)
            .is_none_or(|own| *own >= farthest + places)
    }

    /// Whether an output is an input that another output replaces.
    fn replace_outputs(&self, code: &Code) -> bool {
        code.outputs.iter().zip(&self.outputs).any(|(slot, own)| {
            let input = self.inputs.get(*slot as usize);
            input.is_some_and(|input| input != own && self.outputs.contains(input))
        })
    }
}
