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
                "with a pace the times after a number of steps are not known in advance",
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
                order_of(document, &times.value),
            );
        }
        if (value - end) * step > 0.0 && !is_same_time(value, end) {
            return refuse(
                time,
                format!("the run ends at t = {end:?}, before t = {literal}"),
                "take more `steps`, or leave out the times after the end".to_owned(),
            );
        }
        before = Some(time);
    }
    Ok(())
}

/// How times come to stand in the order of a run: as they are, by steps of the other sign, or sorted.
fn order_of(document: &SceneDocument, times: &[Located<Number>]) -> String {
    let (run, spec) = (&document.run, &document.method.step);
    let step = spec.time_step();
    let values: Vec<f64> = times.iter().map(|time| time.value.value).collect();
    let is_behind = values.iter().all(|time| time * step <= 0.0);
    let is_other_way = is_behind && values.is_sorted_by(|a, b| (b - a) * step < 0.0);
    let has_end = run.until.is_some() || run.comes_to.is_some();
    let signs = ["negative", "positive"];
    let (growing, sign) = match step > 0.0 {
        true => ("growing", signs[0]),
        false => ("falling", signs[1]),
    };
    if is_other_way && !has_end {
        let (key, h) = (spec.key(), -spec.h());
        return format!("a {sign} step comes to them in this order: write {key} = {h:?}");
    }
    let mut ahead: Vec<&Located<Number>> = times
        .iter()
        .filter(|time| time.value.value * step >= 0.0)
        .collect();
    ahead.sort_by(|a, b| (a.value.value * step).total_cmp(&(b.value.value * step)));
    ahead.dedup_by(|a, b| a.value.value == b.value.value);
    let literals: Vec<&str> = ahead
        .iter()
        .map(|time| time.value.literal.as_str())
        .collect();
    match literals.is_empty() {
        true => {
            format!("write times {growing} from 0 on: those on its other side need a {sign} step")
        }
        false => format!(
            "write them {growing} from 0 on: times = [{}]",
            literals.join(", ")
        ),
    }
}
