//! When samples are kept.

use super::Refusal;
use crate::document::{Located, Number, SceneDocument};

/// Roundings of a time that it may be missed by: the length of a step is rounded too.
const MISSED: f64 = 64.0;

/// When a run keeps samples, beside its first and its last state.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleTimes {
    /// After so many steps each.
    Every(u64),
    /// At multiples of a time.
    Interval(f64),
    /// At these times, in the order of the run, all but t = 0.
    Given(Vec<f64>),
}

impl SampleTimes {
    /// What a scene asks for.
    pub(super) fn of(document: &SceneDocument) -> Self {
        let record = &document.run.record;
        if let Some(times) = &record.times {
            let times = times.value.iter().map(|time| time.value.value);
            return Self::Given(times.filter(|time| *time != 0.0).collect());
        }
        match &record.interval {
            Some(interval) => Self::Interval(interval.value.value),
            None => Self::Every(record.every),
        }
    }

    /// Whether a time before the run's end is the end but for rounding. Times that are given beside an end that is given, as with a
    /// pace, are as they are written: each has its own sample.
    pub fn is_end(&self, time: f64, end: f64, until: Option<f64>) -> bool {
        let is_as_written = matches!(self, Self::Given(_)) && until.is_some();
        !is_as_written && is_same_time(time, end)
    }

    /// Whether they are steps.
    pub fn are_steps(&self) -> bool {
        matches!(self, Self::Every(_))
    }

    /// The time of the sample with this number, from 1 on, of a run in the direction of `forward`; `None` behind the last, and
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

/// Refuses times that do not go the way of the run, or lie behind its end.
pub(super) fn check_given_times(document: &SceneDocument) -> Result<(), Refusal> {
    let (run, method) = (&document.run, &document.method);
    let Some(times) = &run.record.times else {
        return Ok(());
    };
    let refuse = |time: &Located<Number>, message: String, help: String| {
        let help = Some(help);
        Err(Box::new(document.diagnostic(
            &time.place(),
            message,
            "here",
            help,
        )))
    };
    let step = method.step.time_step();
    let end = match (&run.until, &method.pace) {
        (Some(until), _) => until.value.value,
        (None, None) => run.steps.value as f64 * step,
        (None, Some(_)) => {
            return Err(Box::new(document.diagnostic(
                &times.place(),
                "with a pace nobody knows which times a number of steps comes to",
                "here",
                Some("write `until`, the time at the end, in place of `steps`".to_owned()),
            )));
        }
    };
    let mut before: Option<&Located<Number>> = None;
    for time in &times.value {
        let (value, literal) = (time.value.value, &time.value.literal);
        let is_ahead = match before {
            None => value * step >= 0.0,
            Some(before) => (value - before.value.value) * step > 0.0,
        };
        if !is_ahead {
            let after = before.map_or("0", |before| before.value.literal.as_str());
            return refuse(
                time,
                format!("the run does not come to t = {literal} after t = {after}"),
                "write times in the order of the run, from 0 on: growing where time-step is positive"
                    .to_owned(),
            );
        }
        if (value - end) * step > 0.0 && !is_same_time(value, end) {
            return refuse(
                time,
                format!("the run ends at t = {end:?}, before t = {literal}"),
                "take more `steps`, or leave out the times behind the end".to_owned(),
            );
        }
        before = Some(time);
    }
    Ok(())
}
