//! How a session begins: at the initial state, or where an earlier one left off.

use std::time::Duration;

use leafwise_core::SolverStatistics;
use leafwise_scene::compose::ComposedRun;
use leafwise_walk::{Course, Memory, SampleTimes, Watched};

use super::Session;
use super::records::Records;
use crate::CHECKPOINT;
use crate::checkpoint::Checkpoint;
use crate::columns::header;
use crate::error::RunError;
use crate::job::Folder;
use crate::samples::{self, Samples};
use crate::states::StateTable;

impl<'a> Session<'a> {
    /// The first session of a run: its initial state is recorded, and a checkpoint written.
    pub fn begin(
        run: &'a ComposedRun,
        course: &'a Course,
        folder: &Folder,
        checkpoint_every: Duration,
    ) -> Result<Self, RunError> {
        let path = |name: &str| folder.join(name);
        let header = header(run);
        let samples = Samples::create(&path(samples::UNPUBLISHED), &header)?;
        let mut session = Self::new(run, course, Some(folder), checkpoint_every, samples)?;
        if let Some(width) = wide(run) {
            session.records.states = Some(StateTable::create(folder, width)?);
        }
        if run.plan.events.section.is_some() {
            let path = path(samples::SECTION);
            session.records.crossings = Some(Samples::create(&path, &header)?);
        }
        session.record()?;
        session.records.samples.publish(&path(samples::FILE))?;
        session.checkpoint()?;
        Ok(session)
    }

    /// A run in memory: its initial state is recorded.
    pub fn in_memory(run: &'a ComposedRun, course: &'a Course) -> Result<Self, RunError> {
        let width = 1 + run.plan.states.width() + run.plan.observables.len();
        let samples = Samples::in_memory(width, rows(run))?;
        let mut session = Self::new(run, course, None, Duration::MAX, samples)?;
        if run.plan.events.section.is_some() {
            session.records.crossings = Some(Samples::in_memory(width, 0)?);
        }
        session.record()?;
        Ok(session)
    }

    /// The next session of a run; no file is changed before [`go_on`](crate::job::JobSession::go_on).
    pub(crate) fn resume(
        run: &'a ComposedRun,
        course: &'a Course,
        folder: &Folder,
        checkpoint: &Checkpoint,
        checkpoint_every: Duration,
    ) -> Result<Self, RunError> {
        let damaged = |reason: String| RunError::Damaged {
            file: folder.join(CHECKPOINT),
            reason,
        };
        let (vouched, count) = (&checkpoint.vouched, checkpoint.samples);
        let path = |name: &str| folder.join(name);
        let header = header(run);
        let samples = Samples::resume(&path(samples::FILE), &header, vouched, count)?;
        let mut session = Self::new(run, course, Some(folder), checkpoint_every, samples)?;
        let records = &mut session.records;
        if let Some(width) = wide(run) {
            let states = StateTable::resume(folder, width, &checkpoint.states)?;
            records.states = Some(states);
        }
        let section = run.plan.events.section.as_ref();
        if section.is_some() {
            let (vouched, count) = (&checkpoint.section, checkpoint.crossings);
            let path = path(samples::SECTION);
            records.crossings = Some(Samples::resume(&path, &header, vouched, count)?);
        }
        let memory = Memory {
            walk: checkpoint.walk.clone(),
            start: checkpoint.start.clone(),
            paced: checkpoint.paced.clone(),
            stop: checkpoint.stop,
            corners: checkpoint.corners.clone(),
            stopped: checkpoint.stopped.clone(),
            events: section
                .map(|_| (checkpoint.side, checkpoint.crossings))
                .into_iter()
                .collect(),
            samples: checkpoint.samples,
            deviation: checkpoint.deviation.clone(),
        };
        let restored = session.watched.restore(&memory);
        restored
            .map_err(|expected| damaged(format!("its lists should have {expected} numbers")))?;
        if checkpoint.windows.initial.len() != records.windows.initial.len()
            || checkpoint.undefined.len() != records.undefined.len()
        {
            return Err(damaged("it is of another system".to_owned()));
        }
        let (made, asked) = (checkpoint.walk.steps, run.plan.steps);
        if made > asked {
            return Err(RunError::Shortened {
                directory: folder.to_path_buf(),
                made,
                asked,
            });
        }
        records.indicators = session.watched.indicators().to_vec();
        records.windows = checkpoint.windows.clone();
        records.watch = checkpoint.watch.clone();
        records.snapshots = checkpoint.snapshots.clone();
        records.last_sample = checkpoint.last_sample;
        records.undefined.clone_from(&checkpoint.undefined);
        records.before = checkpoint.statistics.evaluations;
        session.resumed_at = Some(made);
        session.before = checkpoint.statistics;
        session.wall = Duration::try_from_secs_f64(checkpoint.wall_seconds).unwrap_or_default();
        session.watched.look_again()?;
        Ok(session)
    }

    fn new(
        run: &'a ComposedRun,
        course: &'a Course,
        folder: Option<&Folder>,
        checkpoint_every: Duration,
        samples: Samples,
    ) -> Result<Self, RunError> {
        let parameters = run.system.parameter_values();
        let start = (parameters.as_slice(), run.plan.initial.as_slice());
        let mut watched = Watched::new(course, run.method.map(), 1, start)?;
        let mut records = Records::new(run, course, watched.invariants(), samples)?;
        records.indicators = watched.indicators().to_vec();
        Ok(Self {
            run,
            folder: folder.cloned(),
            checkpoint_every,
            resumed_at: None,
            watched,
            records,
            before: SolverStatistics::default(),
            wall: Duration::ZERO,
        })
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
