//! What an ensemble was reduced to, as files and as JSON.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use super::statistics::{Deviation, Summary};
use crate::csv::{Headings, text_cell};
use crate::json::{json_number, json_numbers};
use crate::{FAILURES, RunError, STATISTICS, WINDOWS, replace};

/// Writes `statistics.csv`, `windows.csv` and, where members failed, `failures.csv`.
pub(super) fn write(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Result<(), RunError> {
    let put = |name: &str, text: String| replace(&report.directory.join(name), text.as_bytes());
    put(STATISTICS, statistics(ensemble, report))?;
    put(WINDOWS, windows(ensemble, report))?;
    if report.reductions.failed > 0 {
        put(FAILURES, failures(ensemble, report))?;
    }
    Ok(())
}

/// A row for each observable and time.
fn statistics(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> String {
    let mut text = String::from(
        "t,observable,count,undefined,mean,variance,minimum,minimum_member,maximum,maximum_member",
    );
    // Writing to a string cannot fail.
    for p in &ensemble.quantiles {
        let _ = write!(text, ",q{p:?}");
    }
    text.push('\n');
    for (steps, name, summary) in summaries(ensemble, report) {
        let (minimum, maximum) = (summary.minimum, summary.maximum);
        let _ = write!(
            text,
            "{:?},{},{},{},{:?},{:?},{:?},{},{:?},{}",
            ensemble.time(steps),
            text_cell(name),
            summary.count,
            summary.undefined,
            summary.mean,
            summary.variance(),
            minimum.0,
            minimum.1,
            maximum.0,
            maximum.1
        );
        for value in summary.quantiles(&ensemble.quantiles) {
            let _ = write!(text, ",{value:?}");
        }
        text.push('\n');
    }
    text
}

/// Every summary with its step and observable.
pub(super) fn summaries<'a>(
    ensemble: &'a ComposedEnsemble,
    report: &'a EnsembleReport,
) -> impl Iterator<Item = (u64, &'a str, &'a Summary)> {
    let names = ensemble.observables();
    let count = names.len();
    let steps = ensemble.sampled_steps();
    let all = report.reductions.summaries.iter().enumerate();
    all.map(move |(at, summary)| (steps[at / count], names[at % count], summary))
}

/// The end of each window, and each invariant's largest deviation in it: over all members, whose it
/// is, and the members' mean.
fn windows(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> String {
    let names = ensemble.invariant_names();
    let mut headings = Headings::default();
    headings.push("t_end", "time");
    for name in &names {
        for heading in ["", "_member", "_mean"] {
            headings.push(&format!("{name}{heading}"), "invariant");
        }
    }
    let mut text = headings.line();
    let rows = report.reductions.windows.chunks_exact(names.len());
    for (steps, row) in ensemble.window_ends().into_iter().zip(rows) {
        let _ = write!(text, "{:?}", ensemble.time(steps));
        for deviation in row {
            let mean = report.reductions.mean_deviation(deviation);
            let (maximum, member) = (deviation.maximum, deviation.member);
            let _ = write!(text, ",{maximum:?},{member},{mean:?}");
        }
        text.push('\n');
    }
    text
}

fn failures(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> String {
    let mut headings = Headings::default();
    headings.extend(["member", "step", "t", "message"], "of the failure");
    headings.extend(ensemble.run.names(), "variable");
    let mut text = headings.line();
    for failure in &report.reductions.failures {
        let _ = write!(
            text,
            "{},{},{:?},{}",
            failure.member,
            failure.step,
            failure.time,
            text_cell(&failure.message)
        );
        for value in &failure.state {
            let _ = write!(text, ",{value:?}");
        }
        text.push('\n');
    }
    text
}

/// The object of `ensemble --json`, but for its outcome and directory; the manifest's end.
pub fn ending(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Value {
    let all = &report.reductions;
    let mut statistics: Vec<Value> = Vec::new();
    for (steps, name, summary) in summaries(ensemble, report) {
        let time = json_number(ensemble.time(steps));
        if statistics.last().is_none_or(|last| last["time"] != time) {
            statistics.push(json!({ "time": time }));
        }
        if let Some(last) = statistics.last_mut() {
            last[name] = summary_json(ensemble, summary);
        }
    }
    let drift: Map<String, Value> = ensemble
        .invariant_names()
        .into_iter()
        .enumerate()
        .map(|(at, name)| (name.to_owned(), drift_json(report, at)))
        .collect();
    let failures: Vec<Value> = all
        .failures
        .iter()
        .map(|failure| {
            json!({
                "member": failure.member, "step": failure.step,
                "time": json_number(failure.time), "message": failure.message,
                "state": json_numbers(&failure.state),
            })
        })
        .collect();
    json!({
        "members": ensemble.population.members(),
        "done": all.done(),
        "failed": all.failed,
        "steps": ensemble.run.plan.steps,
        "time": json_number(ensemble.time(ensemble.run.plan.steps)),
        "wall_seconds": report.wall_seconds,
        "members_per_second": report.rate(),
        "solver": {
            "evaluations_per_step": all.statistics.evaluations_per_step(),
            "operations_per_step": all.statistics.operations_per_step(),
            "failures": all.statistics.failures,
            "rounded": all.statistics.rounded,
        },
        "drift": drift,
        "statistics": statistics,
        "failures": failures,
    })
}

fn summary_json(ensemble: &ComposedEnsemble, summary: &Summary) -> Value {
    let quantiles: Map<String, Value> = ensemble
        .quantiles
        .iter()
        .zip(summary.quantiles(&ensemble.quantiles))
        .map(|(p, value)| (format!("{p:?}"), json_number(value)))
        .collect();
    let mut object = json!({
        "count": summary.count,
        "undefined": summary.undefined,
        "mean": json_number(summary.mean),
        "variance": json_number(summary.variance()),
        "minimum": json_number(summary.minimum.0),
        "minimum_member": summary.minimum.1,
        "maximum": json_number(summary.maximum.0),
        "maximum_member": summary.maximum.1,
    });
    if !quantiles.is_empty() {
        object["quantiles"] = quantiles.into();
        object["rank_error"] = json_number(summary.rank_error());
    }
    object
}

fn drift_json(report: &EnsembleReport, at: usize) -> Value {
    let all = &report.reductions;
    let whole: &Deviation = &all.whole[at];
    json!({
        "maximum": json_number(whole.maximum),
        "member": whole.member,
        "mean": json_number(all.mean_deviation(whole)),
        "relative": json_number(all.relative[at].maximum),
    })
}
