//! When states are recorded.

/// Roundings of a time that it may be missed by: the length of a step is rounded too.
const MISSED: f64 = 64.0;

/// When a walk keeps samples, beside its first and its last state.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleTimes {
    /// After so many steps each.
    Every(u64),
    /// At multiples of a time.
    Interval(f64),
    /// At these times, in the order of the walk, all but t = 0.
    Given(Vec<f64>),
}

impl SampleTimes {
    /// Whether a time before the walk's end is the end but for rounding. Times that are given beside an end that is given, as with a
    /// pace, are as they are written: each has its own sample.
    pub fn is_end(&self, time: f64, end: f64, until: Option<f64>) -> bool {
        let is_as_written = matches!(self, Self::Given(_)) && until.is_some();
        !is_as_written && is_same_time(time, end)
    }

    /// Whether they are steps.
    pub fn are_steps(&self) -> bool {
        matches!(self, Self::Every(_))
    }

    /// The time of the sample with this number, from 1 on, of a walk in the direction of `forward`; `None` behind the last, and
    /// where samples are steps.
    pub fn time(&self, number: u64, forward: f64) -> Option<f64> {
        match self {
            Self::Every(_) => None,
            Self::Interval(interval) => Some(number as f64 * interval.copysign(forward)),
            Self::Given(times) => {
                let at = usize::try_from(number.checked_sub(1)?).ok()?;
                times.get(at).copied()
            }
        }
    }
}

/// Whether two times differ by no more than the rounding of a sum of steps.
pub fn is_same_time(time: f64, other: f64) -> bool {
    (time - other).abs() <= MISSED * f64::EPSILON * other.abs()
}
