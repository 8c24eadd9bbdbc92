//! When samples are kept.

use leafwise_walk::{SampleTimes, is_same_time};

use super::Refusal;
use crate::document::{Located, Number, SceneDocument};

/// When a scene keeps samples.
pub(super) fn sample_times(document: &SceneDocument) -> SampleTimes {
    let record = &document.run.record;
    if let Some(times) = &record.times {
        let times = times.value.iter().map(|time| time.value.value);
        return SampleTimes::Given(times.filter(|time| *time != 0.0).collect());
    }
    match &record.interval {
        Some(interval) => SampleTimes::Interval(interval.value.value),
        None => SampleTimes::Every(record.every),
    }
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
