//! Tables of an ensemble's results: statistics, windows, losses and failures.

use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use super::statistics::Summary;
use crate::csv::{Headings, Table};

/// The columns of `statistics.csv` before the quantiles and the errors of their ranks.
const MOMENTS: [&str; 10] = [
    "t",
    "observable",
    "count",
    "undefined",
    "mean",
    "variance",
    "minimum",
    "minimum_member",
    "maximum",
    "maximum_member",
];

/// A row for each observable and time.
pub(super) fn statistics(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Table {
    let parts = ensemble.quantiles.iter();
    let quantiles = parts.clone().map(|p| format!("q{p:?}"));
    let errors = parts.map(|p| format!("q{p:?}_rank_error"));
    let columns = MOMENTS.map(str::to_owned).into_iter();
    let columns = columns.chain(quantiles).chain(errors);
    let mut table = Table::new(columns);
    for (time, name, summary) in summaries(ensemble, report) {
        let quantiles = summary.quantiles(&ensemble.quantiles);
        let (minimum, maximum) = (summary.minimum, summary.maximum);
        table
            .number(time)
            .text(name)
            .whole(summary.count)
            .whole(summary.undefined)
            .number(summary.mean)
            .number(summary.variance())
            .number(minimum.0)
            .whole(minimum.1)
            .number(maximum.0)
            .whole(maximum.1)
            .numbers(quantiles.iter().map(|of| of.value))
            .numbers(quantiles.iter().map(|of| of.rank_error))
            .end_row();
    }
    table
}

/// Every summary with its time and observable.
pub(super) fn summaries<'a>(
    ensemble: &'a ComposedEnsemble,
    report: &'a EnsembleReport,
) -> impl Iterator<Item = (f64, &'a str, &'a Summary)> {
    let names = ensemble.observables();
    let count = names.len();
    let times = ensemble.sampled();
    let all = report.reductions.summaries.iter().enumerate();
    all.map(move |(at, summary)| (times[at / count], names[at % count], summary))
}

/// The end of each window, and each invariant's largest deviation in it: over all members, whose it
/// is, and the members' mean.
pub(super) fn windows(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Table {
    let names = ensemble.invariant_names();
    let mut headings = Headings::default();
    headings.push("t_end", "time");
    for name in &names {
        for heading in ["", "_member", "_mean"] {
            headings.push(&format!("{name}{heading}"), "invariant");
        }
    }
    let mut table = headings.table();
    let rows = report.reductions.windows.chunks_exact(names.len());
    for (end, row) in ensemble.window_ends().into_iter().zip(rows) {
        table.number(ensemble.clock.time(end));
        for deviation in row {
            table
                .number(deviation.maximum)
                .whole(deviation.member)
                .number(deviation.mean());
        }
        table.end_row();
    }
    table
}

/// How many members have ended by each time, and the part of all with its confidence interval.
pub(super) fn losses(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Table {
    let mut table = Table::new(["t", "stopped", "members", "fraction", "low", "high"]);
    for loss in ensemble.losses(&report.reductions) {
        table
            .number(loss.time)
            .whole(loss.stopped)
            .whole(loss.members)
            .number(loss.fraction)
            .numbers(loss.interval)
            .end_row();
    }
    table
}

/// The first members that failed, each where and why.
pub(super) fn failures(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Table {
    let mut headings = Headings::default();
    headings.extend(["member", "step", "t", "message"], "of the failure");
    headings.extend(ensemble.run.names(), "variable");
    let mut table = headings.table();
    for failure in &report.reductions.failures {
        table
            .whole(failure.member)
            .whole(failure.step)
            .number(failure.time)
            .text(&failure.message)
            .numbers(failure.state.iter().copied())
            .end_row();
    }
    table
}
