//! The step loop.

mod begin;
mod between;

use std::path::Path;
use std::time::{Duration, Instant};

use leafwise_core::{Integrator, SolverStatistics, StepError};

use crate::appended::Vouched;
use crate::checkpoint::Checkpoint;
use crate::columns::invariant_name;
use crate::directory::RunDirectory;
use crate::error::RunError;
use crate::events::{Crossing, Crossings, EventWatch, Side, StopWatch};
use crate::invariants::{Functions, Windows};
use crate::last_step::LastStep;
use crate::outcome::{Failure, RunOutcome};
use crate::paced::Paced;
use crate::progress::{Progress, Status};
use crate::room::NoRoom;
use crate::samples::Samples;
use crate::snapshots::Snapshots;
use crate::states::StateTable;
use crate::watch::Watch;
use leafwise_scene::compose::{ComposedRun, Observable, SampleTimes, WIDEST_STATE};

/// How often waiting samples are handed to the operating system.
const FLUSH_EVERY: Duration = Duration::from_millis(200);

/// Coordinates stepped between two looks at the clock: about a millisecond's work.
const COORDINATES_A_LOOK: usize = 4096;

/// A run between two looks at the clock.
pub(super) struct Session<'a> {
    run: &'a ComposedRun,
    /// Where checkpoints are written, and how often.
    directory: Option<&'a RunDirectory>,
    checkpoint_every: Duration,
    integrator: Integrator,
    /// Where steps are of a fictitious time.
    paced: Option<Paced<'a>>,
    /// Where states between two steps are asked for.
    last: Option<LastStep<'a>>,
    /// Where a condition ends the run.
    stop: Option<StopWatch<'a>>,
    /// What else is looked for, and which of these has ended the run.
    events: Vec<EventWatch<'a>>,
    ended_by: Option<usize>,
    /// Whether it has.
    is_stopped: bool,
    /// Where crossings of a section are recorded, and their rows.
    section: Option<Crossings<'a>>,
    crossings: Option<Samples>,
    /// What an earlier session came to.
    failure: Option<Failure>,
    /// The time and the state at the end, where the run ends between two steps.
    end: Option<(f64, Vec<f64>)>,
    invariants: Functions,
    formulas: Functions,
    columns: Vec<Column>,
    row: Vec<f64>,
    windows: Windows,
    /// States that the method is judged at.
    watch: Watch,
    samples: Samples,
    /// States that are too wide for samples.
    states: Option<StateTable>,
    shown: Vec<f64>,
    snapshots: Snapshots,
    last_sample: Option<u64>,
    /// Whether the state at which a paced run failed is a sample already.
    is_end_recorded: bool,
    undefined: Vec<u64>,
    before: SolverStatistics,
    wall: Duration,
}

/// Where a recorded value comes from.
#[derive(Clone, Copy)]
enum Column {
    Invariant(usize),
    Formula(usize),
    Coordinate(usize),
}

impl<'a> Session<'a> {
    /// Whether all steps were made, or the run has stopped.
    pub fn is_at_end(&self) -> bool {
        if self.is_stopped {
            return true;
        }
        match (&self.paced, self.run.plan.until) {
            (Some(paced), Some(until)) => !paced.is_before(paced.time(&self.integrator), until),
            _ => self.integrator.steps() >= self.run.plan.steps,
        }
    }

    /// Whether a condition has ended the run.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// How the run ended, which is at its end.
    pub fn end_reached(&self) -> RunOutcome {
        let event = self.ended_by.map(|at| self.events[at].text());
        match event.or(self.stop.as_ref().map(StopWatch::text)) {
            Some(text) if self.is_stopped => RunOutcome::Stopped(text.to_owned()),
            _ => RunOutcome::Done,
        }
    }

    /// The crossings of each event, and which of these has ended the run.
    pub fn events_found(&mut self) -> (Vec<Vec<Crossing>>, Option<usize>) {
        let events = self.events.iter_mut();
        let found = events.map(|event| std::mem::take(&mut event.found));
        (found.collect(), self.ended_by)
    }

    /// The time of the present state.
    pub fn time(&self) -> f64 {
        match &self.paced {
            Some(paced) => paced.time(&self.integrator),
            None => self.integrator.time(),
        }
    }

    /// The least and the largest time of a step, where they differ by a pace.
    pub fn step_times(&self) -> Option<[f64; 2]> {
        let steps = &self.paced.as_ref()?.steps;
        (steps.most > 0.0).then_some([steps.least, steps.most])
    }

    /// Takes up the end of a run that has come to it before; no file is changed.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where a file does not end with the run's last row.
    pub fn repeat_end(&mut self) -> Result<(), RunError> {
        // The row waits, and is never handed over: the files have it.
        if let Some(states) = &mut self.states {
            states.freeze();
        }
        self.reach_end();
        self.record_end()?;
        self.record_end_on_section()?;
        self.states
            .as_mut()
            .map_or(Ok(()), StateTable::confirm_end)?;
        self.crossings
            .as_mut()
            .map_or(Ok(()), Samples::confirm_end)?;
        self.samples.confirm_end()
    }

    /// Steps to the end of the plan, to a failure, or until interrupted.
    ///
    /// Done or interrupted, the checkpoint holds the last state. Failed, it stays behind: should
    /// the program be killed before it has said how the run ended, the next session comes to the
    /// same failure with the same counts.
    pub fn drive(&mut self, progress: &mut dyn Progress) -> Result<RunOutcome, RunError> {
        let stride = (COORDINATES_A_LOOK / self.run.dimension().max(1)).max(1);
        let (mut flushed, mut saved) = (Instant::now(), Instant::now());
        let mut failure = self.failure.take();
        if failure.is_none() && !self.is_stopped {
            failure = self.check_values();
        }
        if failure.is_none() {
            // What lies between the end of a shorter run and that of its last step.
            failure = self.record_step()?;
        }
        let outcome = loop {
            let started = Instant::now();
            for _ in 0..stride {
                if failure.is_some() || self.is_at_end() {
                    break;
                }
                failure = self.step()?;
            }
            self.wall += started.elapsed();
            progress.show(&self.status());
            if let Some(failure) = failure {
                break RunOutcome::Failed(failure);
            }
            if self.is_at_end() {
                break match self.reach_end() {
                    None => {
                        self.find_events_at_end();
                        self.end_reached()
                    }
                    Some(failure) => RunOutcome::Failed(failure),
                };
            }
            if progress.is_interrupted() {
                break RunOutcome::Interrupted;
            }
            if saved.elapsed() >= self.checkpoint_every {
                self.checkpoint()?;
                (flushed, saved) = (Instant::now(), Instant::now());
            } else if flushed.elapsed() >= FLUSH_EVERY {
                self.states.as_mut().map_or(Ok(()), StateTable::flush)?;
                self.crossings.as_mut().map_or(Ok(()), Samples::flush)?;
                self.samples.flush()?;
                flushed = Instant::now();
            }
        };
        // The last state is a sample, if the plan's grid has it or not. The checkpoint does not count
        // one off the grid: a run that goes on leaves the same file as one that never stopped.
        if !matches!(outcome, RunOutcome::Failed(_)) {
            self.checkpoint()?;
        }
        if outcome != RunOutcome::Interrupted {
            match outcome {
                RunOutcome::Failed(_) if self.is_end_recorded => {}
                RunOutcome::Failed(_) => self.record_end()?,
                _ => {
                    self.record_end()?;
                    self.record_end_on_section()?;
                }
            }
            self.states.as_mut().map_or(Ok(()), StateTable::end)?;
            self.crossings.as_mut().map_or(Ok(()), Samples::end)?;
            self.samples.end()?;
        }
        Ok(outcome)
    }

    /// One step with its observers.
    fn step(&mut self) -> Result<Option<Failure>, RunError> {
        if let Some(last) = &mut self.last {
            last.keep(&self.integrator);
        }
        self.watch.begin(self.integrator.state());
        if let Err(error) = self.integrator.step() {
            return Ok(Some(self.failure_of_step(&error)));
        }
        self.watch.end(&self.integrator);
        if let (Some(paced), Some(last)) = (&mut self.paced, &self.last)
            && let Some(failure) =
                paced.take(last, (&self.integrator).into(), self.integrator.steps())
        {
            // The state that was reached is none of the motion's.
            self.end = Some((failure.time, last.start.state.clone()));
            let before = self.integrator.steps() - 1;
            self.is_end_recorded = self.last_sample == Some(before);
            return Ok(Some(failure));
        }
        if let Some(failure) = self.find_stop().or_else(|| self.find_events()) {
            return Ok(Some(failure));
        }
        let time = self.time();
        let values = self.invariants.at(self.integrator.state());
        let is_finite = values.iter().all(|value| value.is_finite());
        let outside = if is_finite { None } else { self.check_values() };
        if outside.is_none() {
            let (before, integrator) = (&self.before, &self.integrator);
            self.windows.push(self.invariants.values(), time, || {
                before.evaluations + integrator.evaluations()
            });
        }
        let failure = self.record_step()?;
        Ok(match outside.is_none() || self.is_stopped {
            true => failure,
            false => outside,
        })
    }

    /// Records what the plan asks for of the last step.
    fn record_step(&mut self) -> Result<Option<Failure>, RunError> {
        if let Some(failure) = self.record_crossing()? {
            return Ok(Some(failure));
        }
        let SampleTimes::Every(every) = self.run.plan.samples else {
            return self.record_times();
        };
        let is_beyond = (self.run.plan.until.is_some() || self.is_stopped) && self.is_at_end();
        if self.integrator.steps().is_multiple_of(every) && !is_beyond {
            self.record()?;
        }
        Ok(None)
    }

    fn failure_of_step(&self, error: &StepError) -> Failure {
        let state = self.run.own(self.integrator.state());
        let mut failure = Failure::of_step(error, self.integrator.steps(), self.time(), state);
        failure.of_parts(&self.run.plan.parts);
        failure
    }

    /// The failure of a run that has no memory for its next sample.
    pub fn failure_for_want_of(&self, no_room: NoRoom) -> Failure {
        Failure {
            message: no_room.to_string(),
            step: self.integrator.steps(),
            time: self.time(),
            state: self.run.own(self.integrator.state()).to_vec(),
            hint: "what was recorded before is kept".to_owned(),
        }
    }

    /// Records the state at the end.
    fn record_end(&mut self) -> Result<(), RunError> {
        match self.end.clone() {
            Some((time, state)) => self.record_state(time, &state),
            None => self.record(),
        }
    }

    /// A failure where the state is outside the energy's domain. Where the energy is infinite, or a Casimir has no value, the
    /// motion may be regular: it goes on, and a warning says so.
    fn check_values(&mut self) -> Option<Failure> {
        let state = self.integrator.state();
        if self.invariants.at(state).iter().all(|v| v.is_finite()) {
            return None;
        }
        let is_outside = self.invariants.is_outside(state);
        self.invariants.at(state);
        let (steps, time) = (self.integrator.steps(), self.time());
        let own = self.run.own(state);
        let name = invariant_name(self.run, 0);
        is_outside.then(|| Failure::of_observable(name, steps, time, own))
    }

    /// The invariants without a finite value at the start or at the end, each with whether that is so at the start.
    pub fn undefined_invariants(&mut self) -> Vec<(&'a str, bool)> {
        let end = self.invariants.at(self.integrator.state());
        let pairs = self.windows.initial.iter().zip(end).enumerate();
        let undefined = pairs.filter(|(_, (start, end))| !(start.is_finite() && end.is_finite()));
        let named = undefined.map(|(at, (start, _))| (at, !start.is_finite()));
        named
            .map(|(at, at_start)| (invariant_name(self.run, at), at_start))
            .collect()
    }

    /// Records the present state, once.
    fn record(&mut self) -> Result<(), RunError> {
        let steps = self.integrator.steps();
        if self.last_sample == Some(steps) {
            return Ok(());
        }
        self.record_present(self.time())
    }

    /// Records the present state at its time, which may be rounded otherwise.
    fn record_present(&mut self, time: f64) -> Result<(), RunError> {
        let state = self.integrator.state().to_vec();
        self.record_state(time, &state)?;
        self.last_sample = Some(self.integrator.steps());
        Ok(())
    }

    /// Records a state at its time.
    fn record_state(&mut self, time: f64, state: &[f64]) -> Result<(), RunError> {
        self.fill_row(state);
        for (value, column) in self.row.iter().zip(&self.columns) {
            if let Column::Formula(index) = *column {
                self.undefined[index] += u64::from(!value.is_finite());
            }
        }
        if let Some(states) = &mut self.states {
            let recorded = self.run.plan.states.coordinates();
            states.push(recorded.map(|at| state[at]))?;
        }
        self.samples.push(time, &self.shown, &self.row)?;
        if let Some(geometry) = self.run.method.lattice()
            && state.len() > WIDEST_STATE
        {
            self.snapshots.push(geometry, time, state);
        }
        Ok(())
    }

    /// The columns of a row behind its time: recorded coordinates in `shown`, observables in `row`.
    fn fill_row(&mut self, state: &[f64]) {
        let invariants = self.invariants.at(state);
        let formulas = self.formulas.at(state);
        for (value, column) in self.row.iter_mut().zip(&self.columns) {
            *value = match *column {
                Column::Invariant(index) => invariants[index],
                Column::Formula(index) => formulas[index],
                Column::Coordinate(index) => state[index],
            };
        }
        self.shown.clear();
        if self.states.is_none() {
            let recorded = self.run.plan.states.coordinates();
            self.shown.extend(recorded.map(|at| state[at]));
        }
    }

    fn checkpoint(&mut self) -> Result<(), RunError> {
        let Some(directory) = self.directory else {
            return Ok(());
        };
        let states = self.states.as_mut().map(StateTable::sync).transpose()?;
        let section = self.crossings.as_mut().map(Samples::sync).transpose()?;
        let vouched = self.samples.sync()?;
        let checkpoint = Checkpoint {
            integrator: self.integrator.checkpoint(),
            statistics: self.statistics(),
            wall_seconds: self.wall.as_secs_f64(),
            vouched,
            states: states.unwrap_or(Vouched::NOTHING),
            samples: self.samples.count(),
            last_sample: self.last_sample,
            undefined: self.undefined.clone(),
            windows: self.windows.clone(),
            watch: self.watch.clone(),
            snapshots: self.snapshots.clone(),
            paced: self
                .paced
                .as_ref()
                .map_or_else(Default::default, |paced| paced.steps.clone()),
            section: section.unwrap_or(Vouched::NOTHING),
            crossings: self.crossings().map_or(0, Samples::count),
            side: self
                .section
                .as_ref()
                .map_or_else(Side::default, |section| section.side),
            start: self
                .last
                .as_ref()
                .map_or_else(Default::default, |last| last.start.clone()),
        };
        checkpoint.write(&directory.path)
    }

    /// The solver's work, earlier sessions included.
    pub fn statistics(&self) -> SolverStatistics {
        self.before.and(self.integrator.statistics())
    }

    /// Where the run stands.
    pub fn status(&self) -> Status {
        Status {
            steps: self.integrator.steps(),
            total: self.run.plan.steps,
            time: self
                .end
                .as_ref()
                .map_or_else(|| self.time(), |(time, _)| *time),
            until: self.run.plan.until,
            energy_drift: self.windows.largest().first().copied().unwrap_or(0.0),
        }
    }

    /// The present state, or that at the end.
    pub fn state(&self) -> &[f64] {
        match &self.end {
            Some((_, state)) => state,
            None => self.integrator.state(),
        }
    }

    /// The invariants' deviations.
    pub fn windows(&self) -> &Windows {
        &self.windows
    }

    /// States from which the run has made a step.
    pub fn judged(&self) -> Vec<Vec<f64>> {
        self.watch.judged(&self.run.plan.initial)
    }

    /// States along the run as it is stepped, the last one with them.
    pub fn along(&self) -> Vec<Vec<f64>> {
        let last = self.integrator.state();
        let mut states = self.watch.along(last.len());
        states.push(last.to_vec());
        states
    }

    /// Fields of a long lattice.
    pub fn snapshots(&self) -> &Snapshots {
        &self.snapshots
    }

    /// Samples recorded.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Crossings recorded, where there is a section.
    pub fn crossings(&self) -> Option<&Samples> {
        self.crossings.as_ref()
    }

    /// Both, one row after the other, where they are in memory.
    pub fn into_values(self) -> (Vec<f64>, Option<Vec<f64>>) {
        let crossings = self.crossings.map(Samples::into_values);
        (self.samples.into_values(), crossings)
    }

    /// Whether samples hold the recorded coordinates.
    pub fn has_states_in_samples(&self) -> bool {
        self.states.is_none()
    }

    /// Where the run is written, if it is.
    pub fn directory(&self) -> Option<&Path> {
        self.directory.map(|directory| directory.path.as_path())
    }

    /// For each recorded formula, its name and the samples at which it has no finite value.
    pub fn undefined(&self) -> impl Iterator<Item = (&str, u64)> {
        let observables = self.run.plan.observables.iter();
        let formulas = observables.filter(|o| matches!(o, Observable::Formula { .. }));
        formulas
            .map(Observable::name)
            .zip(self.undefined.iter().copied())
    }

    /// Seconds of integration, earlier sessions included.
    pub fn wall_seconds(&self) -> f64 {
        self.wall.as_secs_f64()
    }
}
