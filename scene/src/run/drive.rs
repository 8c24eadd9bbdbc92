//! The step loop.

use std::time::{Duration, Instant};

use leafwise_core::{Integrator, SolverStatistics};

use super::checkpoint::Checkpoint;
use super::directory::RunDirectory;
use super::error::RunError;
use super::invariants::{Functions, Windows};
use super::outcome::{Failure, RunOutcome};
use super::progress::{Progress, Status};
use super::samples::{Samples, WIDEST_STATE};
use super::snapshots::Snapshots;
use crate::compose::{ComposedRun, Observable};

/// How often waiting samples are handed to the operating system.
const FLUSH_EVERY: Duration = Duration::from_millis(200);

/// Coordinates stepped between two looks at the clock: about a millisecond's work.
const COORDINATES_A_LOOK: usize = 4096;

/// A run between two looks at the clock.
pub(super) struct Session<'a> {
    run: &'a ComposedRun,
    directory: &'a RunDirectory,
    checkpoint_every: Duration,
    integrator: Integrator,
    invariants: Functions,
    formulas: Functions,
    columns: Vec<Column>,
    row: Vec<f64>,
    windows: Windows,
    samples: Samples,
    snapshots: Snapshots,
    last_sample: Option<u64>,
    before: SolverStatistics,
    wall: Duration,
}

/// Where a recorded value comes from.
#[derive(Clone, Copy)]
enum Column {
    Invariant(usize),
    Formula(usize),
}

impl<'a> Session<'a> {
    /// The first session of a run, or the next one after a checkpoint.
    pub fn new(
        run: &'a ComposedRun,
        directory: &'a RunDirectory,
        resumed: Option<&Checkpoint>,
        checkpoint_every: Duration,
    ) -> Result<Self, RunError> {
        let plan = &run.plan;
        let mut invariants = Functions::invariants(run)?;
        let formulas = Functions::formulas(run)?;
        let mut columns = Vec::with_capacity(plan.observables.len());
        let mut formula = 0..;
        for observable in &plan.observables {
            columns.push(match observable {
                Observable::Invariant { index, .. } => Column::Invariant(*index),
                Observable::Formula { .. } => Column::Formula(formula.next().unwrap_or(0)),
            });
        }
        let parameters = run.system.parameter_values();
        let mut integrator = Integrator::new(
            run.method.map(),
            &parameters,
            plan.epsilon,
            plan.h,
            &plan.initial,
        );
        let row = vec![0.0; columns.len()];
        let Some(checkpoint) = resumed else {
            let windows = Windows::new(invariants.at(&plan.initial));
            let samples = Samples::create(&directory.path, &headings(run))?;
            let (before, wall) = (SolverStatistics::default(), Duration::ZERO);
            let mut session = Self {
                run,
                directory,
                checkpoint_every,
                integrator,
                invariants,
                formulas,
                columns,
                row,
                windows,
                samples,
                snapshots: Snapshots::new(),
                last_sample: None,
                before,
                wall,
            };
            session.record()?;
            session.samples.publish()?;
            session.checkpoint()?;
            return Ok(session);
        };
        let damaged = |reason: String| RunError::Damaged {
            file: directory.path.join(super::checkpoint::FILE),
            reason,
        };
        integrator
            .restore(&checkpoint.integrator)
            .map_err(|expected| damaged(format!("its lists should have {expected} numbers")))?;
        if checkpoint.windows.initial.len() != run.system.casimir_names().len() + 1 {
            return Err(damaged("it is of another system".to_owned()));
        }
        let samples =
            Samples::resume(&directory.path, checkpoint.sample_bytes, checkpoint.samples)?;
        Ok(Self {
            run,
            directory,
            checkpoint_every,
            integrator,
            invariants,
            formulas,
            columns,
            row,
            windows: checkpoint.windows.clone(),
            samples,
            snapshots: checkpoint.snapshots.clone(),
            last_sample: checkpoint.last_sample,
            before: checkpoint.statistics,
            wall: Duration::try_from_secs_f64(checkpoint.wall_seconds).unwrap_or_default(),
        })
    }

    /// Steps to the end of the plan, to a failure, or until interrupted.
    ///
    /// Done or interrupted, the checkpoint holds the last state. Failed, it stays behind: should
    /// the program be killed before it has said how the run ended, the next session comes to the
    /// same failure with the same counts.
    pub fn drive(&mut self, progress: &mut dyn Progress) -> Result<RunOutcome, RunError> {
        let total = self.run.plan.steps;
        let stride = (COORDINATES_A_LOOK / self.run.dimension().max(1)).max(1);
        let (mut flushed, mut saved) = (Instant::now(), Instant::now());
        let mut failure = self.check_values();
        let outcome = loop {
            let started = Instant::now();
            for _ in 0..stride {
                if failure.is_some() || self.integrator.steps() >= total {
                    break;
                }
                failure = self.step()?;
            }
            self.wall += started.elapsed();
            progress.show(&self.status());
            if let Some(failure) = failure {
                break RunOutcome::Failed(failure);
            }
            if self.integrator.steps() >= total {
                break RunOutcome::Done;
            }
            if progress.is_interrupted() {
                break RunOutcome::Interrupted;
            }
            if saved.elapsed() >= self.checkpoint_every {
                self.checkpoint()?;
                (flushed, saved) = (Instant::now(), Instant::now());
            } else if flushed.elapsed() >= FLUSH_EVERY {
                self.samples.flush()?;
                flushed = Instant::now();
            }
        };
        // An interrupted run records no extra sample: resumed, it leaves the same file as one
        // that was not.
        if outcome != RunOutcome::Interrupted {
            self.record()?;
            self.samples.end()?;
        }
        if !matches!(outcome, RunOutcome::Failed(_)) {
            self.checkpoint()?;
        }
        Ok(outcome)
    }

    /// One step with its observers.
    fn step(&mut self) -> Result<Option<Failure>, RunError> {
        if let Err(error) = self.integrator.step() {
            let (steps, time) = (self.integrator.steps(), self.integrator.time());
            return Ok(Some(Failure::of_step(
                &error,
                steps,
                time,
                self.integrator.state(),
            )));
        }
        let values = self.invariants.at(self.integrator.state());
        let is_finite = values.iter().all(|value| value.is_finite());
        if is_finite {
            let (before, integrator) = (&self.before, &self.integrator);
            self.windows.push(values, || {
                before.evaluations + integrator.statistics().evaluations
            });
        }
        if self.integrator.steps().is_multiple_of(self.run.plan.every) {
            self.record()?;
        }
        Ok(if is_finite { None } else { self.check_values() })
    }

    /// A failure where the energy or a Casimir has no finite value.
    fn check_values(&mut self) -> Option<Failure> {
        let values = self.invariants.at(self.integrator.state());
        let at = values.iter().position(|value| !value.is_finite())?;
        let name = invariant_name(self.run, at);
        let (steps, time) = (self.integrator.steps(), self.integrator.time());
        Some(Failure::of_observable(
            name,
            steps,
            time,
            self.integrator.state(),
        ))
    }

    /// Records the present state, once.
    fn record(&mut self) -> Result<(), RunError> {
        let steps = self.integrator.steps();
        if self.last_sample == Some(steps) {
            return Ok(());
        }
        let state = self.integrator.state();
        let invariants = self.invariants.at(state);
        let formulas = self.formulas.at(state);
        for (value, column) in self.row.iter_mut().zip(&self.columns) {
            *value = match *column {
                Column::Invariant(index) => invariants[index],
                Column::Formula(index) => formulas[index],
            };
        }
        let shown = if state.len() <= WIDEST_STATE {
            state
        } else {
            &[]
        };
        self.samples
            .push(self.integrator.time(), shown, &self.row)?;
        if let Some(geometry) = self.run.method.lattice()
            && state.len() > WIDEST_STATE
        {
            self.snapshots.push(geometry, self.integrator.time(), state);
        }
        self.last_sample = Some(steps);
        Ok(())
    }

    fn checkpoint(&mut self) -> Result<(), RunError> {
        self.samples.sync()?;
        let (sample_bytes, samples) = self.samples.position();
        let checkpoint = Checkpoint {
            integrator: self.integrator.checkpoint(),
            statistics: self.statistics(),
            wall_seconds: self.wall.as_secs_f64(),
            sample_bytes,
            samples,
            last_sample: self.last_sample,
            windows: self.windows.clone(),
            snapshots: self.snapshots.clone(),
        };
        checkpoint.write(&self.directory.path)
    }

    /// The solver's work, earlier sessions included.
    pub fn statistics(&self) -> SolverStatistics {
        let (before, now) = (self.before, self.integrator.statistics());
        SolverStatistics {
            steps: before.steps + now.steps,
            evaluations: before.evaluations + now.evaluations,
            operations: before.operations.zip(now.operations).map(|(a, b)| a + b),
            most_evaluations: before.most_evaluations.max(now.most_evaluations),
            failures: before.failures + now.failures,
        }
    }

    /// Where the run stands.
    pub fn status(&self) -> Status {
        Status {
            steps: self.integrator.steps(),
            total: self.run.plan.steps,
            time: self.integrator.time(),
            energy_drift: self.windows.largest().first().copied().unwrap_or(0.0),
        }
    }

    /// The present state.
    pub fn state(&self) -> &[f64] {
        self.integrator.state()
    }

    /// The invariants' deviations.
    pub fn windows(&self) -> &Windows {
        &self.windows
    }

    /// Fields of a long lattice.
    pub fn snapshots(&self) -> &Snapshots {
        &self.snapshots
    }

    /// Samples recorded.
    pub fn samples(&self) -> u64 {
        self.samples.position().1
    }

    /// Seconds of integration, earlier sessions included.
    pub fn wall_seconds(&self) -> f64 {
        self.wall.as_secs_f64()
    }
}

/// The name of the energy (0) or of a Casimir.
pub(super) fn invariant_name(run: &ComposedRun, index: usize) -> &str {
    match index.checked_sub(1) {
        None => "energy",
        Some(casimir) => run.system.casimir_names()[casimir],
    }
}

/// The columns of `samples.csv`.
fn headings(run: &ComposedRun) -> Vec<String> {
    let mut headings = vec!["t".to_owned()];
    if run.dimension() <= WIDEST_STATE {
        headings.extend(run.names());
    }
    headings.extend(
        run.plan
            .observables
            .iter()
            .map(|observable| observable.name().to_owned()),
    );
    headings
}
