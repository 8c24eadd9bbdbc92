//! From a composed scene to a complete run directory.

use std::path::{Path, PathBuf};
use std::time::Duration;

use leafwise_core::Registry;

use super::checkpoint::Checkpoint;
use super::columns::{header, headings, invariant_name, windows_headings};
use super::crossing::Crossing;
use super::directory::{REPORT, RunDirectory, RunRequest, SCENE, WINDOWS};
use super::drive::Session;
use super::error::RunError;
use super::manifest::{Beginning, Kind, files, plugins};
use super::outcome::{InvariantDrift, RunOutcome, RunReport};
use super::page::{confirm_page, write_page};
use super::progress::Progress;
use super::replaced::{Put, confirm, replace};
use super::round_off::round_off;
use super::sampled;
use super::samples::Samples;
use super::start;
use super::states::FINAL_STATE;
use super::summary::{report_data, short};
use crate::advice::{Advice, AdviceKind, about_the_scene, advise, casimir_drift};
use crate::csv::Headings;
use leafwise_report::{ReportData, render_report};
use leafwise_scene::compose::{ComposedRun, SceneChecks};
use leafwise_scene::document::SceneDocument;
use leafwise_walk::Event;

/// Where a run is written and what is let pass.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The run directory.
    pub directory: PathBuf,
    /// Replaces the run that the directory holds.
    pub force: bool,
    /// Integrates a tensor that violates the Jacobi identity.
    pub allow_non_poisson: bool,
    /// The command that repeats this run, for the report.
    pub command: String,
    /// How often a checkpoint is written: what a kill costs at most.
    pub checkpoint_every: Duration,
}

impl RunOptions {
    /// The usual [`checkpoint_every`](Self::checkpoint_every).
    pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join(REPORT)
    }
}

/// A run that was kept in memory.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// How it ended.
    pub report: RunReport,
    /// The columns of the tables: the time, recorded coordinates, observables.
    pub columns: Vec<String>,
    /// A row for each sample, one after the other.
    pub samples: Vec<f64>,
    /// The same for each crossing, where there is a section.
    pub crossings: Option<Vec<f64>>,
    /// The columns of [`windows`](Self::windows): the time at the end of a window, and the invariants.
    pub windows_columns: Vec<String>,
    /// The invariants' largest deviations in each window of steps, one row after the other.
    pub windows: Vec<f64>,
    /// Whether it failed for want of memory for more samples.
    pub has_no_room: bool,
    /// The crossings of each of the events that were looked for.
    pub events: Vec<Vec<Crossing>>,
    /// Which of these ended the run, where one did.
    pub ended_by: Option<usize>,
    /// Figures and facts.
    pub page: ReportData,
}

/// Options of a run in memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked<'a> {
    /// Integrates a tensor that violates the Jacobi identity.
    pub allow_non_poisson: bool,
    /// Events to look for beside the scene's own section.
    pub events: &'a [Event],
    /// Does not look for what to change in the scene, which may take as long as building the method.
    pub is_silent: bool,
}

/// Checks the scene as [`run`] does and steps it, with everything recorded in memory, to the same numbers.
///
/// # Errors
/// As [`run`], without those of directories and files.
pub fn run_in_memory(
    document: &SceneDocument,
    composed: &ComposedRun,
    registry: &Registry,
    asked: Asked<'_>,
    progress: &mut dyn Progress,
) -> Result<Recorded, RunError> {
    check(document, composed, asked.allow_non_poisson)?;
    let course = composed.course(asked.events)?;
    let mut session = Session::in_memory(composed, &course)?;
    let (outcome, has_no_room) = match session.drive(progress) {
        // What was kept before stays.
        Err(RunError::NoRoom(no_room)) => (
            RunOutcome::Failed(session.failure_for_want_of(no_room)),
            true,
        ),
        outcome => (outcome?, false),
    };
    let mut report = describe(composed, &session, outcome, None);
    if report.outcome != RunOutcome::Interrupted && !asked.is_silent {
        report.advice = advice(document, composed, registry, &mut session, &report)?;
        report.shadow = sampled::shadow(composed, &session, &report)?;
    }
    let page = report_data(document, composed, &session, &report, "")?;
    let (windows_columns, windows) = windows_of(composed, &session);
    let (events, ended_by) = session.events_found();
    let (samples, crossings) = session.into_values();
    Ok(Recorded {
        report,
        columns: headings(composed, true).into_names(),
        samples,
        crossings,
        windows_columns: windows_columns.into_names(),
        windows: windows.concat(),
        has_no_room,
        events,
        ended_by,
        page,
    })
}

/// The checks of a scene before it is stepped.
fn check(
    document: &SceneDocument,
    composed: &ComposedRun,
    allow_non_poisson: bool,
) -> Result<SceneChecks, RunError> {
    let checks = SceneChecks::of(&composed.system, &composed.near)?;
    let refusal = match checks.refusal(document, &composed.system, allow_non_poisson) {
        Some(refusal) => Some(refusal),
        None => start::refusal(document, composed)?,
    };
    match refusal {
        Some(refusal) => Err(RunError::Refused(refusal)),
        None => Ok(checks),
    }
}

/// Checks the scene with the parts that it may name, then steps it into its directory. An unfinished run of the same
/// scene is resumed, to the same bits as without interruption. So is one, finished or not, whose scene asks for more
/// steps. A finished run of the same scene is reported again, with nothing computed or written.
///
/// Nothing is written before the scene has passed its checks. A numerical failure is an outcome, not an error. The
/// directory is then complete, with everything recorded up to the failure.
///
/// # Errors
/// [`RunError::Refused`] for a tensor that is not Poisson or a Casimir that is not one. The directory's refusals, and
/// failures of the file system.
pub fn run(
    document: &SceneDocument,
    composed: &ComposedRun,
    registry: &Registry,
    options: &RunOptions,
    progress: &mut dyn Progress,
) -> Result<RunReport, RunError> {
    let checks = check(document, composed, options.allow_non_poisson)?;
    let kind = Kind::Run;
    let files = files(composed);
    let asked = RunRequest {
        kind,
        scene: &document.text,
        plugins: &plugins(composed),
        files: files.as_ref(),
        shard: None,
    };
    let directory = RunDirectory::open(&options.directory, &asked, options.force)?;
    let held = directory.held.as_ref();
    let checkpoint = match held {
        Some(_) => Checkpoint::of_unfinished(&directory.path, &header(composed))?,
        None => None,
    };
    let every = options.checkpoint_every;
    let course = composed.course(&[])?;
    let resumed = checkpoint.as_ref();
    let mut resumed = resumed
        .map(|checkpoint| Session::resume(composed, &course, &directory, checkpoint, every))
        .transpose()?;
    let resumed_at = checkpoint.map(|checkpoint| checkpoint.walk.steps);
    if let (Some(session), Some(asked)) = (&resumed, composed.plan.until)
        && held.is_some_and(|held| !held.has_same_steps)
        && session.is_at_end()
        && !session.is_stopped()
    {
        return Err(RunError::Beyond {
            directory: directory.path.clone(),
            reached: session.time(),
            asked,
        });
    }
    if let Some(session) = resumed.as_mut()
        && held.is_some_and(|held| held.is_done && held.is_stopped == session.is_stopped())
        && session.is_at_end()
    {
        session.repeat_end()?;
        let path = &directory.path;
        let outcome = session.outcome();
        let mut report = describe(composed, session, outcome, None);
        report.is_repeated = true;
        report.advice = advice(document, composed, registry, session, &report)?;
        report.shadow = sampled::shadow(composed, session, &report)?;
        write_tables(composed, session, &report, path, confirm)?;
        confirm_page(&path.join(REPORT), || {
            page(document, composed, session, &report, &options.command)
        })?;
        return Ok(report);
    }
    let command = &options.command;
    let started = held.map(|held| held.started.clone());
    let beginning = Beginning::new(kind, document, composed, &checks, command, started);
    // From here on the directory is that of this run, with nothing in it yet or all that was
    // recorded. The scene comes last: should a run that becomes longer be killed before, what is
    // there is the shorter one, unfinished.
    beginning.write_running(&directory.path)?;
    if let Some(session) = &mut resumed {
        session.go_on(held.is_some_and(|held| held.has_same_steps))?;
    }
    replace(&directory.path.join(SCENE), document.text.as_bytes())?;
    let mut session = match resumed {
        Some(session) => session,
        None => Session::begin(composed, &course, &directory, every)?,
    };
    let mut finish = |progress: &mut dyn Progress| -> Result<RunReport, RunError> {
        let outcome = session.drive(progress)?;
        let mut report = describe(composed, &session, outcome, resumed_at);
        // Who interrupts a run wants it to end.
        if report.outcome != RunOutcome::Interrupted {
            report.advice = advice(document, composed, registry, &mut session, &report)?;
            report.shadow = sampled::shadow(composed, &session, &report)?;
        }
        let path = &directory.path;
        write_tables(composed, &session, &report, path, replace)?;
        let page = page(document, composed, &session, &report, &options.command)?;
        write_page(&path.join(REPORT), &page)?;
        beginning.write_ended(path, &report, composed.method.map())?;
        Ok(report)
    };
    finish(progress).map_err(|error| error.with_a_checkpoint(&directory.path))
}

/// Advice on what to change in the scene, judged at states of the run and by its drifts and samples.
fn advice(
    document: &SceneDocument,
    composed: &ComposedRun,
    registry: &Registry,
    session: &mut Session<'_>,
    report: &RunReport,
) -> Result<Vec<Advice>, RunError> {
    let mut advice = about_the_scene(document, composed);
    advice.extend(advise(composed, registry, &session.judged()));
    advice.extend(sampled::energy_error(document, composed, session, report));
    advice.extend(casimir_drift(
        composed,
        &report.invariants,
        &session.along(),
        report.steps,
    ));
    advice.extend(
        session
            .undefined_invariants()
            .into_iter()
            .map(start::unwatched),
    );
    let undefined: Vec<_> = session
        .undefined()
        .filter(|(_, samples)| *samples > 0)
        .collect();
    if undefined.is_empty() {
        return Ok(advice);
    }
    let first = sampled::first_undefined(composed, session)?;
    let time = |name: &str| {
        let found = first.iter().find(|(known, _)| known == name);
        found.map_or_else(String::new, |(_, time)| {
            format!(", first at t = {}", short(*time))
        })
    };
    advice.extend(undefined.into_iter().map(|(name, samples)| Advice {
        kind: AdviceKind::UndefinedObservable,
        message: format!(
            "`{name}` has no finite value at {samples} of {} samples{}: they are recorded as NaN or inf",
            report.samples,
            time(name)
        ),
        change: "observables = [a formula that has values there: no ln or root of a negative \
                 number, no division by zero]"
            .to_owned(),
    }));
    Ok(advice)
}

/// Writes the tables of a run beside its samples: `windows.csv`, and the last state where no other file has it.
fn write_tables(
    composed: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
    directory: &Path,
    put: Put,
) -> Result<(), RunError> {
    let (headings, rows) = windows_of(composed, session);
    let mut table = headings.table();
    for row in rows {
        table.numbers(row).end_row();
    }
    put(&directory.join(WINDOWS), table.as_str().as_bytes())?;
    if !composed.plan.states.is_whole_in_samples() {
        let bytes: Vec<u8> = report
            .final_state
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        put(&directory.join(FINAL_STATE), &bytes)?;
    }
    Ok(())
}

/// `report.html`.
fn page(
    document: &SceneDocument,
    composed: &ComposedRun,
    session: &Session<'_>,
    report: &RunReport,
    command: &str,
) -> Result<String, RunError> {
    let data = report_data(document, composed, session, report, command)?;
    Ok(render_report(&data)?)
}

pub(crate) fn describe(
    composed: &ComposedRun,
    session: &Session<'_>,
    outcome: RunOutcome,
    resumed_at: Option<u64>,
) -> RunReport {
    let windows = session.windows();
    let invariants = windows
        .initial
        .iter()
        .zip(windows.largest())
        .enumerate()
        .map(|(index, (initial, maximum))| InvariantDrift {
            name: invariant_name(composed, index).to_owned(),
            initial: *initial,
            maximum,
            relative: has_size(composed, index, *initial).then(|| maximum / initial.abs()),
        })
        .collect();
    let status = session.status();
    RunReport {
        outcome,
        final_state: composed.own(session.state()).to_vec(),
        time: status.time,
        steps: status.steps,
        step_times: session.step_times(),
        wall_seconds: session.wall_seconds(),
        invariants,
        statistics: session.statistics(),
        samples: session.samples().count(),
        crossings: session.crossings().map(Samples::count),
        resumed_at,
        is_repeated: false,
        shadow: None,
        advice: Vec::new(),
    }
}

/// Whether I(x_0) is more than the round-off of its formula, for a deviation relative to it to mean anything.
fn has_size(composed: &ComposedRun, index: usize, initial: f64) -> bool {
    let formulas = composed.system.expressions();
    let formulas = formulas.filter(|_| composed.method.lattice().is_none());
    let formula = formulas.and_then(|formulas| match index {
        0 => composed.pace().is_none().then_some(formulas.hamiltonian()),
        _ => Some(&formulas.casimirs().get(index - 1)?.expression),
    });
    let bounded =
        formula.and_then(|formula| round_off(composed, formula, &composed.plan.initial, 0.5));
    let least = bounded.filter(|bounded| bounded.error.is_finite());
    initial.abs() > least.map_or(0.0, |bounded| bounded.error)
}

/// The end of each window and the invariants' largest deviations in it.
fn windows_of(composed: &ComposedRun, session: &Session<'_>) -> (Headings, Vec<Vec<f64>>) {
    let windows = session.windows();
    let invariants = 0..windows.initial.len();
    let columns: Vec<Vec<f64>> = invariants.map(|index| windows.series(index)).collect();
    let row = |(at, end): (usize, f64)| {
        let maxima = columns.iter().map(|column| column[at]);
        std::iter::once(end).chain(maxima).collect()
    };
    let rows = windows.ends().into_iter().enumerate().map(row).collect();
    (windows_headings(composed, columns.len()), rows)
}
