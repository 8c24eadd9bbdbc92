//! A run: its walk, stepped into its tables, between two looks at the clock.

mod begin;
mod records;

use std::path::Path;
use std::time::{Duration, Instant};

use leafwise_core::SolverStatistics;
use leafwise_scene::compose::{ComposedRun, Observable};
use leafwise_walk::{Side, Watched, Why};

use self::records::Records;
use crate::appended::Vouched;
use crate::checkpoint::Checkpoint;
use crate::columns::invariant_name;
use crate::crossing::Crossing;
use crate::error::RunError;
use crate::invariants::Windows;
use crate::job::{Folder, Held, JobSession};
use crate::outcome::{Failure, RunOutcome};
use crate::progress::{Progress, Status};
use crate::room::NoRoom;
use crate::samples::Samples;
use crate::snapshots::Snapshots;
use crate::states::StateTable;

/// How often waiting samples are handed to the operating system.
const FLUSH_EVERY: Duration = Duration::from_millis(200);

/// Coordinates stepped between two looks at the clock: about a millisecond's work.
const COORDINATES_A_LOOK: usize = 4096;

/// A run between two looks at the clock.
pub struct Session<'a> {
    run: &'a ComposedRun,
    /// Where checkpoints are written, and how often.
    folder: Option<Folder>,
    checkpoint_every: Duration,
    /// The step that an earlier session had come to.
    pub resumed_at: Option<u64>,
    watched: Watched<'a>,
    records: Records<'a>,
    before: SolverStatistics,
    wall: Duration,
}

impl Session<'_> {
    /// Whether a condition or an event has ended the run.
    fn is_stopped(&self) -> bool {
        let why = self.watched.ended(0).map(|ended| &ended.why);
        matches!(why, Some(Why::Stopped | Why::Event(_)))
    }

    /// How the run ended; interrupted where it has not.
    pub fn outcome(&self) -> RunOutcome {
        let Some(ended) = self.watched.ended(0) else {
            return RunOutcome::Interrupted;
        };
        let course = self.watched.course();
        match &ended.why {
            Why::Done => RunOutcome::Done,
            Why::Stopped => {
                let text = course.stop.as_ref().map(|(stop, _)| stop.text.clone());
                RunOutcome::Stopped(text.unwrap_or_default())
            }
            Why::Event(at) => RunOutcome::Stopped(course.events[*at].0.section.text.clone()),
            Why::Failed(fault) => RunOutcome::Failed(Failure::of(fault, ended, self.run)),
        }
    }

    /// The crossings of each event, and which of these has ended the run.
    pub fn events_found(&mut self) -> (Vec<Vec<Crossing>>, Option<usize>) {
        let found = std::mem::take(&mut self.records.found);
        let own = self.watched.course().events.len() - found.len();
        let ended_by = match self.watched.ended(0).map(|ended| &ended.why) {
            Some(Why::Event(at)) => Some(*at - own),
            _ => None,
        };
        (found, ended_by)
    }

    /// The time of the present state.
    pub fn time(&self) -> f64 {
        self.watched.time(0)
    }

    /// The least and the largest time of a step, where they differ by a pace.
    pub fn step_times(&self) -> Option<[f64; 2]> {
        self.watched.step_times(0)
    }

    /// The failure of a run that has no memory for its next sample.
    pub fn failure_for_want_of(&self, no_room: NoRoom) -> Failure {
        let walk = self.watched.walk();
        Failure {
            message: no_room.to_string(),
            step: walk.steps(),
            time: self.time(),
            state: self.run.own(walk.state()).to_vec(),
            hint: "what was recorded before is kept".to_owned(),
        }
    }

    /// Records the state at the end, and the surfaces that it lies on.
    fn record_end(&mut self) -> Result<(), RunError> {
        if let Some(ended) = self.watched.ended(0) {
            self.records.record_end(ended)?;
        }
        self.watched
            .end_on_events(&mut |look| self.records.take(look))
    }

    /// The invariants without a finite value at the start or at the end, each with whether that is so at the start.
    pub fn undefined_invariants(&mut self) -> Vec<(&str, bool)> {
        let end = self.watched.invariants();
        let pairs = self.records.windows.initial.iter().zip(end).enumerate();
        let undefined = pairs.filter(|(_, (start, end))| !(start.is_finite() && end.is_finite()));
        let named = undefined.map(|(at, (start, _))| (at, !start.is_finite()));
        named
            .map(|(at, at_start)| (invariant_name(self.run, at), at_start))
            .collect()
    }

    /// Records the present state, once.
    fn record(&mut self) -> Result<(), RunError> {
        let (walk, time) = (self.watched.walk(), self.watched.time(0));
        self.records.record(walk.steps(), time, walk.state())
    }

    fn checkpoint(&mut self) -> Result<(), RunError> {
        let Some(folder) = &self.folder else {
            return Ok(());
        };
        let statistics = self.statistics();
        let records = &mut self.records;
        let states = records.states.as_mut().map(StateTable::sync).transpose()?;
        let section = records.crossings.as_mut().map(Samples::sync).transpose()?;
        let vouched = records.samples.sync()?;
        let memory = self.watched.memory();
        let checkpoint = Checkpoint {
            walk: memory.walk,
            statistics,
            wall_seconds: self.wall.as_secs_f64(),
            vouched,
            states: states.unwrap_or(Vouched::NOTHING),
            samples: records.samples.count(),
            last_sample: records.last_sample,
            undefined: records.undefined.clone(),
            windows: records.windows.clone(),
            watch: records.watch.clone(),
            snapshots: records.snapshots.clone(),
            paced: memory.paced,
            section: section.unwrap_or(Vouched::NOTHING),
            crossings: records.crossings.as_ref().map_or(0, Samples::count),
            side: memory
                .events
                .first()
                .map_or_else(Side::default, |(side, _)| *side),
            stop: memory.stop,
            corners: memory.corners,
            stopped: memory.stopped,
            start: memory.start,
            deviation: memory.deviation,
        };
        checkpoint.write(folder)
    }

    /// The solver's work, earlier sessions included.
    pub fn statistics(&self) -> SolverStatistics {
        self.before.and(self.watched.statistics())
    }

    /// Where the run stands.
    pub fn status(&self) -> Status {
        let ended = self.watched.ended(0);
        Status {
            steps: self.watched.walk().steps(),
            total: self.run.plan.steps,
            time: ended.map_or_else(|| self.time(), |ended| ended.time),
            until: self.run.plan.until,
            energy_drift: self.windows().largest().first().copied().unwrap_or(0.0),
        }
    }

    /// The present state, or that at the end.
    pub fn state(&self) -> &[f64] {
        let ended = self.watched.ended(0);
        ended.map_or_else(|| self.watched.walk().state(), |ended| &ended.state)
    }

    /// The invariants' deviations.
    pub(crate) fn windows(&self) -> &Windows {
        &self.records.windows
    }

    /// States from which the run has made a step.
    pub fn judged(&self) -> Vec<Vec<f64>> {
        self.records.watch.judged(&self.run.plan.initial)
    }

    /// States along the run as it is stepped, the last one with them.
    pub fn along(&self) -> Vec<Vec<f64>> {
        let last = self.watched.walk().state();
        let mut states = self.records.watch.along(last.len());
        states.push(last.to_vec());
        states
    }

    /// Fields of a long lattice.
    pub(crate) fn snapshots(&self) -> &Snapshots {
        &self.records.snapshots
    }

    /// Samples recorded.
    pub(crate) fn samples(&self) -> &Samples {
        &self.records.samples
    }

    /// Crossings recorded, where there is a section.
    pub(crate) fn crossings(&self) -> Option<&Samples> {
        self.records.crossings.as_ref()
    }

    /// Both, one row after the other, where they are in memory.
    pub fn into_values(self) -> (Vec<f64>, Option<Vec<f64>>) {
        let crossings = self.records.crossings.map(Samples::into_values);
        (self.records.samples.into_values(), crossings)
    }

    /// Whether samples hold the recorded coordinates.
    pub fn has_states_in_samples(&self) -> bool {
        self.records.states.is_none()
    }

    /// Where the run is written, if it is.
    pub fn directory(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// For each recorded formula, its name and the samples at which it has no finite value.
    pub fn undefined(&self) -> impl Iterator<Item = (&str, u64)> {
        let observables = self.run.plan.observables.iter();
        let formulas = observables.filter(|o| matches!(o, Observable::Formula { .. }));
        formulas
            .map(Observable::name)
            .zip(self.records.undefined.iter().copied())
    }

    /// Seconds of integration, earlier sessions included.
    pub fn wall_seconds(&self) -> f64 {
        self.wall.as_secs_f64()
    }
}

impl JobSession for Session<'_> {
    /// Takes up the end of a run, of as many steps as its scene asks for.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where a file does not end with the run's last row, [`RunError::Beyond`] where the run has
    /// gone further in time.
    fn repeat(&mut self, held: &Held) -> Result<Option<RunOutcome>, RunError> {
        let (is_stopped, is_at_end) = (self.is_stopped(), self.watched.is_at_end());
        if let (Some(asked), Some(directory)) = (self.run.plan.until, &self.folder)
            && !held.has_same_steps
            && is_at_end
        {
            let reached = self.status().time;
            // Where a run has stopped, it ends for all later times.
            let is_earlier = (asked - reached) * self.run.plan.epsilon * self.run.plan.h < 0.0;
            if !is_stopped || is_earlier {
                return Err(RunError::Beyond {
                    directory: directory.to_path_buf(),
                    reached,
                    asked,
                });
            }
        }
        if !(held.is_done && held.is_stopped == is_stopped && is_at_end) {
            return Ok(None);
        }
        // The row waits, and is never handed over: the files have it.
        if let Some(states) = &mut self.records.states {
            states.freeze();
        }
        self.watched.arrive()?;
        self.record_end()?;
        let records = &mut self.records;
        records
            .states
            .as_mut()
            .map_or(Ok(()), StateTable::confirm_end)?;
        records
            .crossings
            .as_mut()
            .map_or(Ok(()), Samples::confirm_end)?;
        records.samples.confirm_end()?;
        Ok(Some(self.outcome()))
    }

    fn go_on(&mut self, held: &Held) -> Result<(), RunError> {
        // Otherwise the run is to become longer.
        let has_same_plan = held.has_same_steps;
        let records = &mut self.records;
        if let Some(states) = &mut records.states {
            states.go_on(has_same_plan)?;
        }
        if let Some(crossings) = &mut records.crossings {
            crossings.go_on(has_same_plan)?;
        }
        records.samples.go_on(has_same_plan)
    }

    /// Steps to the end of the plan, to a failure, or until interrupted.
    ///
    /// Done or interrupted, the checkpoint holds the last state. Failed, it stays behind: should
    /// the program be killed before it has said how the run ended, the next session comes to the
    /// same failure with the same counts.
    fn drive(&mut self, progress: &mut dyn Progress) -> Result<RunOutcome, RunError> {
        let stride = (COORDINATES_A_LOOK / self.run.dimension().max(1)).max(1) as u64;
        let (mut flushed, mut saved) = (Instant::now(), Instant::now());
        self.records.watch.begin(self.watched.walk().state());
        self.watched.begin(&mut |look| self.records.take(look))?;
        loop {
            let started = Instant::now();
            self.watched
                .advance(stride, &mut |look| self.records.take(look))?;
            self.wall += started.elapsed();
            progress.show(&self.status());
            if self.watched.walk().living() == 0 || progress.is_interrupted() {
                break;
            }
            if saved.elapsed() >= self.checkpoint_every {
                self.checkpoint()?;
                (flushed, saved) = (Instant::now(), Instant::now());
            } else if flushed.elapsed() >= FLUSH_EVERY {
                let records = &mut self.records;
                records.states.as_mut().map_or(Ok(()), StateTable::flush)?;
                records.crossings.as_mut().map_or(Ok(()), Samples::flush)?;
                records.samples.flush()?;
                flushed = Instant::now();
            }
        }
        // The last state is a sample, if the plan's grid has it or not. The checkpoint does not count
        // one off the grid: a run that goes on leaves the same file as one that never stopped.
        if !matches!(self.outcome(), RunOutcome::Failed(_)) {
            self.checkpoint()?;
        }
        if self.watched.ended(0).is_some() {
            self.record_end()?;
            let records = &mut self.records;
            records.states.as_mut().map_or(Ok(()), StateTable::end)?;
            records.crossings.as_mut().map_or(Ok(()), Samples::end)?;
            records.samples.end()?;
        }
        Ok(self.outcome())
    }
}
