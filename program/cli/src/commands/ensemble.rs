//! `leafwise ensemble`: many members, reduced into a run directory.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use leafwise::core::Registry;
use leafwise::expression::words::counted;
use leafwise::run::ensemble::{
    ComposedEnsemble, EnsembleEnding, EnsembleJob, EnsembleReport, MemberError, Workforce,
    advise_ensemble, compose_ensemble, member_scene,
};
use leafwise::run::shards::{Portion, Shard, Whole};
use leafwise::run::{Advice, RunOutcome, perform};
use leafwise::scene::SceneDocument;
use leafwise::scene::compose::compose;
use serde::Serialize;

use super::run::{drift, integrate, method_line, print_advice, repeating};
use super::shard;
use crate::arguments::{EnsembleArguments, OutputArguments, PluginArguments};
use crate::bar::{Bar, while_building};
use crate::console::Console;
use crate::failure::Failure;
use crate::plugins::Parts;
use crate::table::{duration, grouped, numbers, short};

/// Failed members that are named on the terminal.
const MOST_NAMED: usize = 5;

/// Said of an ensemble that has come to its end before.
const REPEATED: &str =
    "it was already complete: nothing was computed or written; --force runs it again";

/// The object of `ensemble --json`.
#[derive(Serialize)]
struct EnsembleJson<'a> {
    #[serde(flatten)]
    ending: EnsembleEnding<'a>,
    warnings: &'a [Advice],
    run_directory: String,
}

/// Integrates the ensemble, or one of its members; returns the exit code.
///
/// # Errors
/// [`Failure`] when it cannot be started or written.
pub fn execute(
    arguments: &EnsembleArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let file = &arguments.scene.scene;
    let directory = file.parent().unwrap_or(Path::new(""));
    let ensemble = compose_ensemble(&document, &parts.registry, directory)?;
    if let Some(member) = arguments.member {
        let scene = member_document(member, &document, &ensemble, &parts)?;
        return execute_member(arguments, &scene, &parts, plugins, console, interrupt);
    }
    let members = ensemble.population.members();
    let shard = match (&arguments.members, &arguments.shard) {
        (Some(text), _) => Some(shard::of_members(text, members)?),
        (None, Some(text)) => Some(shard::of_number(text, Whole::Members, members)?),
        (None, None) => None,
    };
    let output = arguments.output;
    let portion = Portion::computed(shard.as_ref());
    let options = output.options(
        shard::directory(&arguments.out, &document, &portion, Whole::Members),
        repeating(
            "ensemble",
            file.file_name(),
            output.allow_non_poisson,
            plugins,
        ),
    );
    let workforce = Workforce {
        threads: arguments
            .threads
            .unwrap_or_else(|| Workforce::default().threads),
        lanes: arguments.lanes,
    };
    let shown = console.shown(output.quiet);
    let members = match &shard {
        None => ensemble.population.members(),
        Some(shard) => shard.items().end - shard.items().start,
    };
    let total = members.saturating_mul(ensemble.steps().unwrap_or(1));
    let mut bar = Bar::new(total, shown, interrupt);
    let job = EnsembleJob::new(&document, &ensemble, portion, &options, workforce);
    let report = job.and_then(|job| perform(&job, &mut bar));
    bar.finish();
    let report = report?;
    if let Some(shard) = &shard {
        return Ok(tell_shard(shard, &report, output, console));
    }
    let mut advice = report.advice.clone();
    if report.outcome == RunOutcome::Done {
        advice.extend(advise_ensemble(&ensemble, &parts.registry));
    }
    tell(
        (&ensemble, &parts.registry),
        &report,
        &advice,
        output,
        console,
    )
}

/// Prints what an ensemble was reduced to; returns the exit code.
pub(super) fn tell(
    (ensemble, registry): (&ComposedEnsemble, &Registry),
    report: &EnsembleReport,
    advice: &[Advice],
    output: OutputArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    if !output.quiet {
        for line in summary(ensemble, registry, report, console) {
            console.prose(&line);
        }
        print_advice(advice, console);
    }
    // As a failed run these are told in any case.
    if report.reductions.failed > 0 {
        console.prose("");
        for line in failures(report, console) {
            console.prose(&line);
        }
    }
    if output.json {
        console.json(&EnsembleJson {
            ending: EnsembleEnding::new(ensemble, report),
            warnings: advice,
            run_directory: report.directory.display().to_string(),
        });
    }
    let all = &report.reductions;
    let made = [all.members, all.failed];
    Ok(shard::exit_code(&report.outcome, made, false))
}

/// The object of `ensemble --shard --json`.
#[derive(Serialize)]
struct ShardJson {
    outcome: &'static str,
    members: [u64; 2],
    done: u64,
    failed: u64,
    wall_seconds: f64,
    members_per_second: f64,
    run_directory: String,
}

/// Prints a line of a shard; returns the exit code.
fn tell_shard(
    shard: &Shard,
    report: &EnsembleReport,
    output: OutputArguments,
    console: &mut Console<'_>,
) -> u8 {
    let all = &report.reductions;
    let members = shard.items();
    if !output.quiet {
        let outcome = match report.outcome {
            RunOutcome::Interrupted => format!(
                "stopped after {} of them, with a checkpoint: the same command continues from there",
                grouped(all.members)
            ),
            _ if report.is_repeated => {
                "it was already complete: nothing was computed or written".to_owned()
            }
            _ => format!(
                "{} failed, {}, {} members a second",
                grouped(all.failed),
                duration(report.wall_seconds),
                grouped(report.rate() as u64)
            ),
        };
        console.prose(&format!(
            "{}: {}: {outcome}: {}",
            report.outcome.word(),
            shard.describe(),
            report.directory.display()
        ));
    }
    if output.json {
        console.json(&ShardJson {
            outcome: report.outcome.word(),
            members: [members.start, members.end],
            done: all.members,
            failed: all.failed,
            wall_seconds: report.wall_seconds,
            members_per_second: report.rate(),
            run_directory: report.directory.display().to_string(),
        });
    }
    shard::exit_code(&report.outcome, [all.members, all.failed], true)
}

/// One member as a scene of its own.
fn member_document(
    member: u64,
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    parts: &Parts,
) -> Result<SceneDocument, Failure> {
    let text = member_scene(document, ensemble, member).map_err(|error| {
        let help = match error {
            MemberError::Absent { .. } => "members are counted from 0",
            _ => "take another member",
        };
        Failure::usage(error.to_string(), help)
    })?;
    let stem = Path::new(&document.name).file_stem().unwrap_or_default();
    let file = format!("{}-member-{member}.toml", stem.to_string_lossy());
    SceneDocument::parse(&file, &text, &parts.registry)
        .map_err(|errors| Failure::Scene(errors.diagnostics()))
}

/// That scene as an ordinary run.
fn execute_member(
    arguments: &EnsembleArguments,
    scene: &SceneDocument,
    parts: &Parts,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let composed = while_building(console.shown(arguments.output.quiet), || {
        compose(scene, &parts.registry)
    })?;
    let file = Path::new(&scene.name);
    let output = arguments.output;
    let directory = arguments.out.clone();
    let options = output.options(
        directory.unwrap_or_else(|| Path::new("runs").join(file.with_extension(""))),
        repeating("run", file.file_name(), output.allow_non_poisson, plugins),
    );
    integrate(
        (scene, &composed),
        &parts.registry,
        &options,
        (output, false),
        console,
        interrupt,
    )
}

fn summary(
    ensemble: &ComposedEnsemble,
    registry: &Registry,
    report: &EnsembleReport,
    console: &Console<'_>,
) -> Vec<String> {
    let all = &report.reductions;
    let end = ensemble.end();
    let mut lines = vec![format!(
        "{}: {} to t = {} with {}",
        console.bold(report.outcome.word()),
        match all.failed {
            0 => format!("{} members", grouped(all.members)),
            failed => format!(
                "{} members, {} of them failed,",
                grouped(all.members),
                grouped(failed)
            ),
        },
        short(end),
        method_line(&ensemble.run, registry)
    )];
    if let Some(member) = report.resumed_at {
        lines.push(format!("resumed at member {}", grouped(member)));
    }
    if report.is_repeated {
        lines.push(REPEATED.to_owned());
    }
    if all.done() > 0 {
        lines.push(String::new());
        lines.extend(end_table(ensemble, report));
        lines.push(String::new());
        lines.extend(drift_table(ensemble, report));
    }
    lines.push(String::new());
    if let (Some(stop), Some(last)) = (&ensemble.run.plan.events.stop, ensemble.losses(all).last())
    {
        let [part, low, high] = [last.fraction, last.interval[0], last.interval[1]].map(percent);
        lines.push(format!(
            "  stopped  {} of {} members by {}: {part} %, {low} to {high} % with 95 % confidence, in losses.csv",
            grouped(last.stopped),
            grouped(last.members),
            stop.text
        ));
    }
    if let (Some(section), Some(count)) = (&ensemble.run.plan.events.section, report.crossings) {
        let which = section.direction_in_words();
        lines.push(format!(
            "  section  {} of {}, {which}, in section.csv",
            counted(count as usize, "crossing"),
            section.text
        ));
    }
    if let Some(ranks) = report.ranks(ensemble) {
        lines.push(format!("  ranks    quantiles are {ranks}"));
    }
    lines.push(format!("  solver   {}", all.statistics.summary()));
    let threads = match report.threads {
        0 => String::new(),
        1 => " on 1 thread".to_owned(),
        threads => format!(" on {threads} threads"),
    };
    lines.push(format!(
        "  time     {}{threads}, {} members a second",
        duration(report.wall_seconds),
        grouped(report.rate() as u64)
    ));
    lines.push(format!("  report   {}", report.report().display()));
    if report.outcome == RunOutcome::Interrupted {
        lines.push(String::new());
        lines.push(format!(
            "stopped after {} of {} members, with a checkpoint: the same command continues from there",
            grouped(all.members),
            grouped(ensemble.population.members())
        ));
    }
    lines
}

/// The observables at the end.
fn end_table(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Vec<String> {
    let mut heading = [
        "  at the end",
        "mean",
        "± 95 %",
        "deviation",
        "smallest",
        "largest",
    ]
    .map(str::to_owned)
    .to_vec();
    let parts = ensemble.quantiles.iter();
    heading.extend(parts.map(|p| format!("{}%", short(100.0 * p))));
    let mut rows = vec![heading];
    let names = ensemble.observables();
    let last = &report.reductions.summaries;
    let last = &last[last.len() - names.len()..];
    for (name, summary) in names.iter().zip(last) {
        let values = [summary.deviation(), summary.minimum.0, summary.maximum.0];
        let quantiles = summary.quantiles(&ensemble.quantiles).into_iter();
        let quantiles = quantiles.map(|of| of.value);
        let confidence = format!("{:.1e}", summary.confidence());
        let mut row = vec![format!("  {name}"), digits(summary.mean), confidence];
        row.extend(values.into_iter().chain(quantiles).map(digits));
        rows.push(row);
    }
    numbers(&rows)
}

/// A part as a percentage of three digits.
fn percent(part: f64) -> String {
    let text = format!("{:.2e}", 100.0 * part);
    text.parse().map_or(text, short)
}

/// A value with eight digits.
fn digits(value: f64) -> String {
    let text = format!("{value:.7e}");
    text.parse().map_or(text, short)
}

fn drift_table(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> Vec<String> {
    let all = &report.reductions;
    let heading = [
        "  drift",
        "largest",
        "member",
        "relative",
        "mean of members",
    ];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    for (at, name) in ensemble.invariant_names().iter().enumerate() {
        let whole = &all.whole[at];
        rows.push(vec![
            format!("  {name}"),
            drift(whole.maximum),
            whole.member.to_string(),
            drift(all.relative[at].maximum),
            drift(whole.mean()),
        ]);
    }
    numbers(&rows)
}

fn failures(report: &EnsembleReport, console: &Console<'_>) -> Vec<String> {
    let all = &report.reductions;
    let statistics = match all.failed < all.members {
        true => "the statistics cover the others",
        false => "there are no statistics",
    };
    let mut lines = vec![format!(
        "{} {} of {} members failed; {statistics}",
        console.error_word(),
        grouped(all.failed),
        grouped(all.members)
    )];
    for failure in all.failures.iter().take(MOST_NAMED) {
        lines.push(format!(
            "  member {}, step {}, t = {}: {}",
            failure.member,
            failure.step,
            short(failure.time),
            failure.message
        ));
    }
    if let Some(first) = all.failures.first() {
        lines.push(format!(
            "  = help: --member {} runs that one alone; {} holds the first {}",
            first.member,
            report.directory.join("failures.csv").display(),
            all.failures.len()
        ));
    }
    lines
}
