//! How a session begins: at the initial state, or where an earlier one left off.

use std::time::Duration;

use leafwise_core::{Integrator, SolverStatistics};
use leafwise_scene::compose::{ComposedRun, Observable, SampleTimes};

use super::{Column, Session};
use crate::checkpoint::{Checkpoint, FILE};
use crate::columns::header;
use crate::directory::RunDirectory;
use crate::error::RunError;
use crate::events::{Crossings, Event, EventWatch, StopWatch};
use crate::invariants::{Functions, Windows};
use crate::last_step::LastStep;
use crate::paced::Paced;
use crate::samples::{self, Samples};
use crate::snapshots::Snapshots;
use crate::states::StateTable;
use crate::watch::Watch;

impl<'a> Session<'a> {
    /// The first session of a run: its initial state is recorded, and a checkpoint written.
    pub fn begin(
        run: &'a ComposedRun,
        directory: &'a RunDirectory,
        checkpoint_every: Duration,
    ) -> Result<Self, RunError> {
        let path = |name: &str| directory.path.join(name);
        let header = header(run);
        let samples = Samples::create(&path(samples::UNPUBLISHED), &header)?;
        let mut session = Self::new(run, Some(directory), checkpoint_every, samples)?;
        if let Some(width) = wide(run) {
            session.states = Some(StateTable::create(&directory.path, width)?);
        }
        if session.section.is_some() {
            session.crossings = Some(Samples::create(&path(samples::SECTION), &header)?);
        }
        session.record()?;
        session.samples.publish(&path(samples::FILE))?;
        session.checkpoint()?;
        Ok(session)
    }

    /// A run in memory that looks for events: its initial state is recorded.
    pub fn in_memory(run: &'a ComposedRun, events: &'a [Event]) -> Result<Self, RunError> {
        let width = 1 + run.plan.states.width() + run.plan.observables.len();
        let samples = Samples::in_memory(width, rows(run))?;
        let mut session = Self::new(run, None, Duration::MAX, samples)?;
        for event in events {
            session.events.push(EventWatch::new(run, event)?);
            session.last.get_or_insert_with(|| LastStep::new(run));
        }
        if session.section.is_some() {
            session.crossings = Some(Samples::in_memory(width, 0)?);
        }
        session.record()?;
        Ok(session)
    }

    /// The next session of a run; no file is changed before [`go_on`](Self::go_on).
    pub fn resume(
        run: &'a ComposedRun,
        directory: &'a RunDirectory,
        checkpoint: &Checkpoint,
        checkpoint_every: Duration,
    ) -> Result<Self, RunError> {
        let damaged = |reason: String| RunError::Damaged {
            file: directory.path.join(FILE),
            reason,
        };
        let (vouched, count) = (&checkpoint.vouched, checkpoint.samples);
        let path = |name: &str| directory.path.join(name);
        let header = header(run);
        let samples = Samples::resume(&path(samples::FILE), &header, vouched, count)?;
        let mut session = Self::new(run, Some(directory), checkpoint_every, samples)?;
        if let Some(width) = wide(run) {
            session.states = Some(StateTable::resume(
                &directory.path,
                width,
                &checkpoint.states,
            )?);
        }
        if let Some(section) = &mut session.section {
            let (vouched, count) = (&checkpoint.section, checkpoint.crossings);
            section.side = checkpoint.side;
            let path = path(samples::SECTION);
            session.crossings = Some(Samples::resume(&path, &header, vouched, count)?);
        }
        session
            .integrator
            .restore(&checkpoint.integrator)
            .map_err(|expected| damaged(format!("its lists should have {expected} numbers")))?;
        if checkpoint.windows.initial.len() != session.windows.initial.len()
            || checkpoint.undefined.len() != session.undefined.len()
        {
            return Err(damaged("it is of another system".to_owned()));
        }
        let (made, asked) = (checkpoint.integrator.steps, run.plan.steps);
        if made > asked {
            return Err(RunError::Shortened {
                directory: directory.path.clone(),
                made,
                asked,
            });
        }
        if let Some(paced) = &mut session.paced {
            paced.steps = checkpoint.paced.clone();
        }
        if let Some(last) = &mut session.last {
            if checkpoint.start.state.len() != last.start.state.len() {
                return Err(damaged("it is of another system".to_owned()));
            }
            last.start = checkpoint.start.clone();
        }
        session.windows = checkpoint.windows.clone();
        session.watch = checkpoint.watch.clone();
        session.snapshots = checkpoint.snapshots.clone();
        session.last_sample = checkpoint.last_sample;
        session.undefined.clone_from(&checkpoint.undefined);
        session.before = checkpoint.statistics;
        session.wall = Duration::try_from_secs_f64(checkpoint.wall_seconds).unwrap_or_default();
        if made > 0 {
            session.failure = session.find_stop();
        }
        Ok(session)
    }

    fn new(
        run: &'a ComposedRun,
        directory: Option<&'a RunDirectory>,
        checkpoint_every: Duration,
        samples: Samples,
    ) -> Result<Self, RunError> {
        let plan = &run.plan;
        let mut invariants = Functions::invariants(run)?;
        let formulas = Functions::formulas(run)?;
        let mut columns = Vec::with_capacity(plan.observables.len());
        let mut formula = 0;
        for observable in &plan.observables {
            columns.push(match observable {
                Observable::Invariant { index, .. } => Column::Invariant(*index),
                Observable::Formula { .. } => {
                    formula += 1;
                    Column::Formula(formula - 1)
                }
                Observable::Coordinate { index, .. } => Column::Coordinate(*index),
            });
        }
        let parameters = run.system.parameter_values();
        let (map, epsilon, h) = (run.method.map(), plan.epsilon, plan.h);
        let (paced, stop) = (Paced::of(run)?, StopWatch::of(run)?);
        let section = Crossings::of(run)?;
        let is_between =
            paced.is_some() || stop.is_some() || section.is_some() || !plan.samples.are_steps();
        Ok(Self {
            run,
            directory,
            checkpoint_every,
            integrator: Integrator::new(map, &parameters, epsilon, h, &plan.initial),
            paced,
            last: is_between.then(|| LastStep::new(run)),
            stop,
            events: Vec::new(),
            ended_by: None,
            is_stopped: false,
            section,
            crossings: None,
            failure: None,
            end: None,
            windows: Windows::new(invariants.at(&plan.initial)),
            watch: Watch::new(&plan.initial),
            invariants,
            formulas,
            row: vec![0.0; columns.len()],
            columns,
            samples,
            states: None,
            shown: Vec::new(),
            snapshots: Snapshots::new(),
            last_sample: None,
            is_end_recorded: false,
            undefined: vec![0; formula],
            before: SolverStatistics::default(),
            wall: Duration::ZERO,
        })
    }

    /// Prepares the files of an earlier session for more steps; `has_same_plan` unless the run is to
    /// become longer.
    pub fn go_on(&mut self, has_same_plan: bool) -> Result<(), RunError> {
        if let Some(states) = &mut self.states {
            states.go_on(has_same_plan)?;
        }
        if let Some(crossings) = &mut self.crossings {
            crossings.go_on(has_same_plan)?;
        }
        self.samples.go_on(has_same_plan)
    }
}

/// The number of recorded coordinates where they are too many for `samples.csv`.
fn wide(run: &ComposedRun) -> Option<usize> {
    let states = &run.plan.states;
    (!states.are_in_samples()).then(|| states.width())
}

/// How many samples a run keeps at most, where that is known before.
fn rows(run: &ComposedRun) -> u64 {
    let steps = run.plan.steps;
    match &run.plan.samples {
        // The first, and the last state where it is none of them.
        SampleTimes::Every(every) if run.plan.until.is_none() => {
            steps / every + 1 + u64::from(!steps.is_multiple_of(*every))
        }
        SampleTimes::Given(times) => times.len() as u64 + 2,
        _ => 0,
    }
}
