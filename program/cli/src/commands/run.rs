//! `leafwise run`: a scene into a run directory.

use std::ffi::OsStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use leafwise::core::{Registry, SolverStatistics};
use leafwise::run::advice::splitting_instead;
use leafwise::run::{
    Advice, AdviceKind, ChaosVerdict, Failure as StepFailure, InvariantDrift, Kind, NoStateError,
    RunJob, RunOptions, RunOutcome, RunReport, ShadowVerdict, SolverFields, StateError,
    after_origin, default_directory, perform,
};
use leafwise::scene::SceneDocument;
use leafwise::scene::compose::{ComposedRun, WIDEST_STATE, compose};
use leafwise::scene::json::{Double, doubles, object};
use serde::Serialize;

use super::explain::explain;
use crate::arguments::{OutputArguments, PluginArguments, RunArguments};
use crate::bar::{Bar, while_building};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::{duration, grouped, numbers, short};

/// Coordinates of a state that a message shows.
const SHOWN_COORDINATES: usize = 12;

/// Said of a run that has come to its end before.
pub(super) const REPEATED: &str = "it was already complete: nothing was computed or written; larger `steps` \
                                   or `until` continue it, --force runs it again";

/// Said of a run that its condition has ended before.
const STAYS: &str =
    "it had already stopped there: nothing was computed or written; --force runs it again";

/// Integrates the scene; returns the exit code.
///
/// # Errors
/// [`Failure`] when the run cannot be started or written.
pub fn execute(
    arguments: &RunArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let start = Instant::now();
    let mut parts = Parts::new(plugins)?;
    let document = parts.scene(&arguments.scene)?;
    let composed = while_building(console.shown(arguments.output.quiet), || {
        compose(&document, &parts.registry)
    })?;
    if arguments.explain {
        for line in explain(&composed, &parts.registry, start)? {
            console.prose(&line);
        }
        console.prose("");
    }
    let output = arguments.output;
    let directory = arguments.out.clone();
    let file = arguments.scene.scene.file_name();
    let options = RunOptions {
        // Longer than any number of seconds that a duration holds is never.
        checkpoint_every: Duration::try_from_secs_f64(arguments.checkpoint_every)
            .unwrap_or(Duration::MAX),
        ..output.options(
            directory.unwrap_or_else(|| default_directory(&document, Kind::Run)),
            repeating("run", file, output.allow_non_poisson, plugins),
        )
    };
    if document.ensemble.is_some() && !output.quiet {
        console.prose("the initial state of [run] alone; `leafwise ensemble` runs [ensemble]");
    }
    integrate(
        (&document, &composed),
        &parts.registry,
        &options,
        (output, arguments.error),
        console,
        interrupt,
    )
}

/// Integrates a composed scene, and estimates the error of its states where that is wanted; returns the exit code.
///
/// # Errors
/// [`Failure`] when the run cannot be started or written.
pub(super) fn integrate(
    (document, composed): (&SceneDocument, &ComposedRun),
    registry: &Registry,
    options: &RunOptions,
    (output, estimates_error): (OutputArguments, bool),
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let shown = console.shown(output.quiet);
    let mut bar = Bar::new(composed.plan.steps, shown, interrupt);
    let job = RunJob::new(document, composed, registry, options);
    let report = job.and_then(|job| perform(&job, &mut bar));
    bar.finish();
    let report = report?;
    if !output.quiet {
        for line in summary(composed, registry, &report, options, console) {
            console.prose(&line);
        }
        print_advice(&report.advice, console);
    }
    if let RunOutcome::Failed(failure) = &report.outcome {
        for line in failure_lines(composed, failure, &report, options, console) {
            console.prose(&line);
        }
    }
    let is_estimated = estimates_error || document.run.estimates_error.is_some();
    let is_interrupted = || interrupt.load(Ordering::Relaxed);
    let error = is_estimated
        .then(|| StateError::of_report(composed, &report, &is_interrupted))
        .flatten();
    if let Some(error) = error.as_ref().filter(|_| !output.quiet) {
        console.prose(&match error {
            Ok(error) => format!("  error    {}", error.text()),
            Err(no) => format!("  error    not estimated: {no}"),
        });
    }
    if output.json {
        console.json(&RunJson::new(composed, &report, error, options));
    }
    Ok(match report.outcome {
        RunOutcome::Done | RunOutcome::Stopped(_) => exit::DONE,
        RunOutcome::Interrupted => exit::INTERRUPTED,
        RunOutcome::Failed(_) => exit::RUN_FAILED,
    })
}

/// Prints advice, a warning each: its message, and what to change in the scene.
pub(super) fn print_advice(advice: &[Advice], console: &mut Console<'_>) {
    for one in advice {
        let word = console.warning_word();
        console.prose("");
        console.prose(&format!("{word} {}", one.message));
        for line in one.change.lines() {
            console.prose(&format!("  = change: {line}"));
        }
        console.prose(&format!("  = more: leafwise explain {}", one.kind.word()));
    }
}

/// The command that runs a file once more, overrides already in it.
pub(super) fn repeating(
    verb: &str,
    file: Option<&OsStr>,
    allow_non_poisson: bool,
    plugins: &PluginArguments,
) -> String {
    let file = file.unwrap_or_default().to_string_lossy();
    let mut command = format!("leafwise {verb} {file}");
    if allow_non_poisson {
        command.push_str(" --allow-non-poisson");
    }
    for plugin in &plugins.plugins {
        // A bare name is searched for from everywhere; a path leads there from here.
        let path = plugin.canonicalize().ok();
        let path = path.filter(|_| plugin.components().count() > 1);
        let path = path.as_deref().unwrap_or(plugin);
        command.push_str(&format!(" --plugin {}", quoted(&path.to_string_lossy())));
    }
    command
}

/// A word of a command line.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+".contains(c);
    if word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// The parts of a run in one line.
pub(super) fn method_line(composed: &ComposedRun, registry: &Registry) -> String {
    let parts = composed.plan.parts.iter().map(|part| part.line(registry));
    parts.collect::<Vec<_>>().join(" + ")
}

fn summary(
    composed: &ComposedRun,
    registry: &Registry,
    report: &RunReport,
    options: &RunOptions,
    console: &Console<'_>,
) -> Vec<String> {
    let method = method_line(composed, registry);
    let word = console.bold(report.outcome.word());
    let noun = if report.steps == 1 { "step" } else { "steps" };
    let (steps, time) = (
        format!("{} {noun}", grouped(report.steps)),
        short(report.time),
    );
    let mut lines = vec![match report.outcome.stopped_by() {
        Some(condition) => {
            let origin = after_origin(composed);
            format!("{word} at t = {time}{origin}: {condition}, after {steps} with {method}")
        }
        None => format!("{word}: {steps} to t = {time} with {method}"),
    }];
    if let Some(step) = report.resumed_at {
        lines.push(format!("resumed at step {}", grouped(step)));
    }
    if report.is_repeated {
        let is_stopped = report.outcome.stopped_by().is_some();
        lines.push(if is_stopped { STAYS } else { REPEATED }.to_owned());
    }
    lines.push(String::new());
    let mut rows = vec![vec![
        String::new(),
        "initial".to_owned(),
        "largest drift".to_owned(),
        "relative".to_owned(),
    ]];
    for invariant in &report.invariants {
        rows.push(vec![
            format!("  {}", invariant.name),
            short(invariant.initial),
            drift(invariant.maximum),
            invariant.relative.map_or_else(|| "-".to_owned(), drift),
        ]);
    }
    lines.extend(numbers(&rows));
    if composed.plan.drift_every > 1 {
        let every = grouped(composed.plan.drift_every);
        lines.push(format!("  drifts   of one step in {every}"));
    }
    lines.push(String::new());
    let rate = report.steps as f64 / report.wall_seconds.max(1e-9);
    lines.push(format!("  solver   {}", report.statistics.summary()));
    if let Some([least, most]) = report.step_times {
        lines.push(format!("  steps    of t from {least:.3e} to {most:.3e}"));
    }
    lines.push(format!(
        "  time     {}, {} steps a second",
        duration(report.wall_seconds),
        grouped(rate as u64)
    ));
    if let (Some(section), Some(count)) = (&composed.plan.events.section, report.crossings) {
        lines.push(format!(
            "  section  {} {} of {}, {}, in section.csv",
            grouped(count),
            if count == 1 { "crossing" } else { "crossings" },
            section.text,
            section.direction_in_words()
        ));
        let acts = composed.plan.events.act_text();
        lines.extend(acts.map(|text| format!("  events   each {text}")));
    }
    lines.extend(
        report
            .shadow
            .map(|shadow| format!("  shadow   {}", shadow.text())),
    );
    lines.extend(
        report
            .chaos
            .map(|chaos| format!("  motion   {}", chaos.text())),
    );
    lines.extend(
        composed
            .work_of_forces()
            .map(|text| format!("  energy   {text}")),
    );
    lines.extend(splitting_line(composed, registry, report));
    lines.extend(states_line(composed).map(|line| format!("  states   {line}")));
    lines.push(format!("  report   {}", options.report().display()));
    if report.outcome == RunOutcome::Interrupted {
        lines.push(String::new());
        let whole = match composed.plan.until {
            None => format!(" of {}", grouped(composed.plan.steps)),
            Some(until) => format!(", at t = {} of {}", short(report.time), short(until)),
        };
        lines.push(format!(
            "stopped at step {}{whole}, with a checkpoint: the same command continues from there",
            grouped(report.steps)
        ));
    }
    lines
}

/// The stepper that solves nothing, where H is a sum that it takes and no warning names it.
fn splitting_line(
    composed: &ComposedRun,
    registry: &Registry,
    report: &RunReport,
) -> Option<String> {
    let is_named = |one: &Advice| one.kind == AdviceKind::NoPoissonMap;
    if report.outcome != RunOutcome::Done || report.advice.iter().any(is_named) {
        return None;
    }
    let name = splitting_instead(composed, registry)?;
    Some(format!(
        "  method   H is a sum of pieces with exact flows, and stepper = \"{name}\" solves no equations: --explain measures both"
    ))
}

/// Where states are that `samples.csv` does not hold, or how to record some.
fn states_line(composed: &ComposedRun) -> Option<String> {
    let states = &composed.plan.states;
    if !states.are_in_samples() {
        return Some(format!(
            "{} coordinates at every record, in states.npy",
            grouped(states.width() as u64)
        ));
    }
    if states.is_chosen || composed.plan.layout.coordinates() <= WIDEST_STATE {
        return None;
    }
    let lattice = composed.method.lattice();
    let example = match composed.plan.families.first() {
        Some(_) if lattice.is_some_and(|lattice| lattice.axes.len() > 1) => {
            format!("\"{}\"", composed.names()[0])
        }
        Some((name, _)) => format!("\"{name}[0]\", \"{name}[::100]\""),
        None => composed.names().first().map(|name| format!("\"{name}\""))?,
    };
    Some(format!(
        "of {} coordinates only the last is kept, in final_state.bin: record = {{ states = [{example}] }} \
         or states = \"all\" keeps them over time",
        grouped(composed.dimension() as u64)
    ))
}

fn failure_lines(
    composed: &ComposedRun,
    failure: &StepFailure,
    report: &RunReport,
    options: &RunOptions,
    console: &Console<'_>,
) -> Vec<String> {
    let mut state: Vec<String> = composed
        .names()
        .iter()
        .zip(&failure.state)
        .take(SHOWN_COORDINATES)
        .map(|(name, value)| format!("{name} = {value:?}"))
        .collect();
    if failure.state.len() > SHOWN_COORDINATES {
        state.push(format!("… ({} coordinates)", failure.state.len()));
    }
    vec![
        String::new(),
        format!(
            "{} step {} failed at t = {}: {}",
            console.error_word(),
            failure.step,
            short(failure.time),
            failure.message
        ),
        format!("  state before it: {}", state.join(", ")),
        format!("  = help: {}", failure.hint),
        format!(
            "  = everything recorded before it is in {} (samples: {})",
            options.directory.display(),
            grouped(report.samples)
        ),
        "  = more: leafwise explain failed steps".to_owned(),
    ]
}

/// The object of `run --json`.
#[derive(Serialize)]
struct RunJson<'a> {
    outcome: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped_by: Option<&'a str>,
    #[serde(serialize_with = "doubles")]
    final_state: &'a [f64],
    time: Double,
    steps: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    crossings: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step_times: Option<[f64; 2]>,
    wall_seconds: f64,
    #[serde(serialize_with = "object")]
    drift: Vec<(&'a str, Double)>,
    #[serde(serialize_with = "object")]
    invariants: Vec<(&'a str, &'a InvariantDrift)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    work: Option<String>,
    #[serde(with = "SolverFields")]
    solver: SolverStatistics,
    #[serde(skip_serializing_if = "Option::is_none")]
    shadow: Option<ShadowVerdict>,
    #[serde(skip_serializing_if = "Option::is_none")]
    chaos: Option<ChaosVerdict>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state_error: Option<StateError>,
    #[serde(skip_serializing_if = "Option::is_none")]
    no_state_error: Option<String>,
    warnings: &'a [Advice],
    run_directory: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a StepFailure>,
}

impl<'a> RunJson<'a> {
    fn new(
        composed: &ComposedRun,
        report: &'a RunReport,
        error: Option<Result<StateError, NoStateError>>,
        options: &RunOptions,
    ) -> Self {
        Self {
            outcome: report.outcome.word(),
            stopped_by: report.outcome.stopped_by(),
            final_state: &report.final_state,
            time: Double(report.time),
            steps: report.steps,
            crossings: report.crossings,
            step_times: report.step_times,
            wall_seconds: report.wall_seconds,
            drift: report.drift(),
            invariants: report.named_invariants(),
            work: composed.work_of_forces(),
            solver: report.statistics,
            shadow: report.shadow,
            chaos: report.chaos,
            no_state_error: (error.as_ref())
                .and_then(|error| error.as_ref().err())
                .map(ToString::to_string),
            state_error: error.and_then(Result::ok),
            warnings: &report.advice,
            run_directory: options.directory.display().to_string(),
            error: report.outcome.failure(),
        }
    }
}

/// A deviation with three digits.
pub(super) fn drift(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.2e}")
    }
}
