//! A run of one trajectory: as a job with a directory, and in memory.

use std::path::Path;

use leafwise_core::Registry;

use super::checkpoint::Checkpoint;
use super::columns::{header, headings, invariant_name, windows_headings};
use super::crossing::Crossing;
use super::drive::Session;
use super::ending::RunEnding;
use super::error::RunError;
use super::invariants::InvariantDrift;
use super::outcome::{RunOutcome, RunReport};
use super::progress::Progress;
use super::round_off::round_off;
use super::samples::{self, Samples};
use super::shown::short;
use super::summary::report_data;
use super::{sampled, start, states};
use crate::advice::{Advice, AdviceKind, JudgedStates, about_the_scene, advise, casimir_drift};
use crate::csv::Headings;
use crate::job::{
    Beginning, Content, Folder, Job, JobSession, JobSubject, Kind, Output, RunOptions, files,
};
use leafwise_report::{ReportData, render_report};
use leafwise_scene::compose::{ComposedRun, SceneChecks};
use leafwise_scene::document::SceneDocument;
use leafwise_walk::{Course, Event};

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

/// Checks the scene as [`RunJob::new`] does and steps it, with everything recorded in memory, to the same numbers.
///
/// # Errors
/// As [`RunJob::new`]; observables without code.
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
    let mut report = describe(composed, &session, outcome);
    if !asked.is_silent {
        judge(document, composed, registry, &mut session, &mut report)?;
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
    let checks = start::checked(document, composed, allow_non_poisson)?;
    match start::refusal(document, composed)? {
        Some(refusal) => Err(RunError::Refused(refusal)),
        None => Ok(checks),
    }
}

/// A run of one trajectory, whose scene has passed its checks.
///
/// An unfinished run of the same scene is resumed. So is one, finished or not, whose scene asks for more steps. A
/// numerical failure is an outcome, not an error: the directory is then complete, with everything recorded up to it.
pub struct RunJob<'a> {
    document: &'a SceneDocument,
    composed: &'a ComposedRun,
    registry: &'a Registry,
    options: &'a RunOptions,
    checks: SceneChecks,
    course: Course,
}

impl<'a> RunJob<'a> {
    /// Checks a scene with the parts that it may name.
    ///
    /// # Errors
    /// [`RunError::Refused`] for a tensor that is not Poisson or a Casimir that is not one.
    pub fn new(
        document: &'a SceneDocument,
        composed: &'a ComposedRun,
        registry: &'a Registry,
        options: &'a RunOptions,
    ) -> Result<Self, RunError> {
        Ok(Self {
            document,
            composed,
            registry,
            options,
            checks: check(document, composed, options.allow_non_poisson)?,
            course: composed.course(&[])?,
        })
    }

    /// `windows.csv`.
    fn windows(&self, session: &Session<'a>, _: &RunReport) -> Content {
        let (headings, rows) = windows_of(self.composed, session);
        let mut table = headings.table();
        for row in rows {
            table.numbers(row).end_row();
        }
        Ok(Some(table.into_bytes()))
    }

    /// The last state, where no other file has it.
    fn final_state(&self, _: &Session<'a>, report: &RunReport) -> Content {
        let is_elsewhere = self.composed.plan.states.is_whole_in_samples();
        let state = report.final_state.iter();
        Ok((!is_elsewhere).then(|| state.flat_map(|x| x.to_le_bytes()).collect()))
    }

    /// `report.html`.
    fn page(&self, session: &Session<'a>, report: &RunReport) -> Content {
        let command = &self.options.command;
        let data = report_data(self.document, self.composed, session, report, command)?;
        Ok(Some(render_report(&data)?.into_bytes()))
    }
}

impl<'a> Job<'a> for RunJob<'a> {
    type Session = Session<'a>;
    type Report = RunReport;

    const RECORDS: &'static [&'static str] = &[
        samples::FILE,
        samples::UNPUBLISHED,
        samples::SECTION,
        states::FILE,
    ];

    fn outputs() -> Vec<Output<Self, Session<'a>, RunReport>> {
        vec![
            Output::table("windows.csv", Self::windows),
            Output::table(states::FINAL_STATE, Self::final_state),
            Output::page(Self::page),
        ]
    }

    fn subject(&self) -> JobSubject<'_> {
        JobSubject {
            kind: Kind::Run,
            document: self.document,
            run: self.composed,
            checks: &self.checks,
            files: files(self.composed),
            shard: None,
            sources: Vec::new(),
            options: self.options,
        }
    }

    fn has_begun_at_most(&self, directory: &Path) -> bool {
        samples::has_begun_at_most(directory, &header(self.composed))
    }

    fn begin(&'a self, folder: &Folder) -> Result<Session<'a>, RunError> {
        let every = self.options.checkpoint_every;
        Session::begin(self.composed, &self.course, folder, every)
    }

    fn resume(&'a self, folder: &Folder) -> Result<Session<'a>, RunError> {
        let (checkpoint, every) = (Checkpoint::read(folder)?, self.options.checkpoint_every);
        Session::resume(self.composed, &self.course, folder, &checkpoint, every)
    }

    fn report(
        &self,
        session: &mut Session<'a>,
        outcome: RunOutcome,
        is_repeated: bool,
    ) -> Result<RunReport, RunError> {
        let mut report = describe(self.composed, session, outcome);
        report.resumed_at = session.resumed_at.filter(|_| !is_repeated);
        report.is_repeated = is_repeated;
        judge(
            self.document,
            self.composed,
            self.registry,
            session,
            &mut report,
        )?;
        Ok(report)
    }

    fn write_end(
        &self,
        beginning: Beginning<'_>,
        report: &RunReport,
        directory: &Path,
    ) -> Result<(), RunError> {
        let ending = RunEnding::new(report, self.composed.method.map());
        beginning
            .of_samples(report.samples)
            .write_end(directory, ending)
    }
}

/// Judges a run that has ended. Who interrupts one wants it to end.
fn judge(
    document: &SceneDocument,
    composed: &ComposedRun,
    registry: &Registry,
    session: &mut Session<'_>,
    report: &mut RunReport,
) -> Result<(), RunError> {
    if report.outcome != RunOutcome::Interrupted {
        report.advice = advice(document, composed, registry, session, report)?;
        report.shadow = sampled::shadow(composed, session, report)?;
        report.chaos = sampled::chaos(composed, session, report)?;
    }
    Ok(())
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
    advice.extend(advise(
        composed,
        registry,
        (&session.judged(), JudgedStates::OfTheRun),
    ));
    advice.extend(sampled::energy_error(composed, session, report));
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

pub(crate) fn describe(
    composed: &ComposedRun,
    session: &Session<'_>,
    outcome: RunOutcome,
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
        resumed_at: None,
        is_repeated: false,
        shadow: None,
        chaos: None,
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
