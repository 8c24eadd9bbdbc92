//! `leafwise sweep`: one run for each of many settings, into one table.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use leafwise::run::shards::{Portion, Shard, Whole};
use leafwise::run::sweep::{Settings, SweepEnding, SweepJob, SweepReport, compose_sweep};
use leafwise::run::{RunOutcome, perform};
use serde::Serialize;

use super::run::repeating;
use super::shard;
use crate::arguments::{OutputArguments, PluginArguments, SweepArguments};
use crate::bar::{Bar, Steps};
use crate::console::Console;
use crate::failure::Failure;
use crate::plugins::Parts;
use crate::table::{duration, grouped};

/// The object of `sweep --json`.
#[derive(Serialize)]
struct SweepJson<'a> {
    #[serde(flatten)]
    ending: SweepEnding<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shard: Option<[u64; 2]>,
    run_directory: String,
}

/// Runs the settings, or a shard of them; returns the exit code.
///
/// # Errors
/// [`Failure`] when it cannot be started or written.
pub fn execute(
    arguments: &SweepArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let settings = Settings::of(&document)?;
    let count = settings.count();
    let shard = arguments.shard.as_ref();
    let shard = shard.map(|text| shard::of_number(text, Whole::Settings, count));
    let shard = shard.transpose()?;
    let items = shard.as_ref().map_or(0..count, Shard::items);
    let output = arguments.output;
    let allow = output.allow_non_poisson;
    let shown = console.shown(output.quiet);
    let mut line = Steps::new("building: from formulas to code", shown);
    let progress_of =
        &mut |at: u64, count: u64| line.show("settings composed", at as usize, count as usize);
    let sweep = compose_sweep(
        &document,
        &parts.registry,
        settings,
        items.clone(),
        allow,
        progress_of,
    );
    line.finish();
    let sweep = sweep?;
    let portion = Portion::computed(shard.as_ref());
    let file = arguments.scene.scene.file_name();
    let options = output.options(
        shard::directory(&arguments.out, &document, &portion, Whole::Settings),
        repeating("sweep", file, allow, plugins),
    );
    let every = || std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let threads = arguments.threads.unwrap_or_else(every);
    let total = (items.end - items.start).saturating_mul(sweep.base.plan.steps);
    let mut bar = Bar::new(total, shown, interrupt);
    let job = SweepJob::new(&document, &sweep, portion, &options, threads);
    let report = perform(&job, &mut bar);
    bar.finish();
    let report = report?;
    Ok(tell(&report, shard.as_ref(), output, console))
}

/// Prints what a sweep has come to; returns the exit code.
pub(super) fn tell(
    report: &SweepReport,
    part: Option<&Shard>,
    output: OutputArguments,
    console: &mut Console<'_>,
) -> u8 {
    if !output.quiet {
        for line in summary(report, part, console) {
            console.prose(&line);
        }
    }
    // As a failed run these are told in any case.
    if report.failed > 0 {
        console.prose(&format!(
            "{} {} of {} settings failed; the column `error` of {} says why",
            console.error_word(),
            grouped(report.failed),
            grouped(report.done),
            report.table().display()
        ));
    }
    if output.json {
        console.json(&SweepJson {
            ending: SweepEnding::new(report),
            shard: part.map(|shard| [shard.items().start, shard.items().end]),
            run_directory: report.directory.display().to_string(),
        });
    }
    shard::exit_code(
        &report.outcome,
        [report.done, report.failed],
        part.is_some(),
    )
}

fn summary(report: &SweepReport, shard: Option<&Shard>, console: &Console<'_>) -> Vec<String> {
    let what = match shard {
        Some(shard) => shard.describe(),
        None => format!("{} settings", grouped(report.settings)),
    };
    let mut lines = vec![format!(
        "{}: {what}, {} failed",
        console.bold(report.outcome.word()),
        grouped(report.failed)
    )];
    if let Some(setting) = report.resumed_at {
        lines.push(format!("resumed at setting {}", grouped(setting)));
    }
    if report.is_repeated {
        lines.push(
            "it was already complete: nothing was computed or written; --force runs it again"
                .to_owned(),
        );
    }
    lines.push(format!(
        "  time     {}, {} settings a second",
        duration(report.wall_seconds),
        grouped(report.rate() as u64)
    ));
    lines.push(format!("  table    {}", report.table().display()));
    if shard.is_none() {
        lines.push(format!("  report   {}", report.report().display()));
    }
    if report.outcome == RunOutcome::Interrupted {
        lines.push(format!(
            "stopped after {} of {} settings, with a checkpoint: the same command continues from there",
            grouped(report.done),
            grouped(report.settings)
        ));
    }
    lines
}
