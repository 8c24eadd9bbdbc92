//! Row of the table: the results of the run of a setting.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::settings::{Settings, cell};
use crate::csv::Table;
use crate::drive::Session;
use crate::execute::describe;
use crate::job::JobSession;
use crate::{Progress, RunError, RunOutcome, Status};
use leafwise_scene::compose::ComposedRun;

/// A run that has ended.
pub(super) struct Row {
    setting: u64,
    outcome: &'static str,
    /// Why it failed.
    error: String,
    time: f64,
    drifts: Vec<f64>,
    observables: Vec<f64>,
    steps: u64,
    evaluations: u64,
    operations: Option<u64>,
}

/// Signals to and from all runs meanwhile: a count of steps, and a flag to stop.
#[derive(Debug, Default)]
pub(super) struct Signals {
    pub steps: AtomicU64,
    pub stop: AtomicBool,
}

/// One of them.
struct Counted<'a> {
    signals: &'a Signals,
    steps: u64,
}

impl Progress for Counted<'_> {
    fn show(&mut self, status: &Status) {
        let made = status.steps - self.steps;
        self.signals.steps.fetch_add(made, Ordering::Relaxed);
        self.steps = status.steps;
    }

    fn is_interrupted(&self) -> bool {
        self.signals.stop.load(Ordering::Relaxed)
    }
}

impl Row {
    /// Runs a setting; `None` where it was told to stop.
    pub fn of(
        setting: u64,
        run: &ComposedRun,
        signals: &Signals,
    ) -> Result<Option<Self>, RunError> {
        let course = run.course(&[])?;
        let mut session = Session::in_memory(run, &course)?;
        let mut watched = Counted { signals, steps: 0 };
        let outcome = session.drive(&mut watched)?;
        if outcome == RunOutcome::Interrupted {
            return Ok(None);
        }
        let report = describe(run, &session, outcome);
        let error = report
            .outcome
            .failure()
            .map_or_else(String::new, |failure| {
                format!(
                    "step {}: {}; {}",
                    failure.step, failure.message, failure.hint
                )
            });
        let (samples, _) = session.into_values();
        let first = samples.len() - run.plan.observables.len();
        Ok(Some(Self {
            setting,
            outcome: report.outcome.word(),
            error,
            time: report.time,
            drifts: report.invariants.iter().map(|one| one.maximum).collect(),
            observables: samples[first..].to_vec(),
            steps: report.steps,
            evaluations: report.statistics.evaluations,
            operations: report.statistics.operations,
        }))
    }

    /// Whether the run has failed.
    pub fn has_failed(&self) -> bool {
        !self.error.is_empty()
    }

    /// The largest deviation of the energy.
    pub fn energy_drift(&self) -> f64 {
        self.drifts.first().copied().unwrap_or(0.0)
    }

    /// The row as text.
    pub fn write(&self, settings: &Settings, table: &mut Table) {
        table.whole(self.setting);
        for value in settings.values(self.setting) {
            table.text(&value.map_or_else(String::new, cell));
        }
        table.text(self.outcome).text(&self.error).number(self.time);
        table.numbers(self.drifts.iter().chain(&self.observables).copied());
        table.whole(self.steps).whole(self.evaluations);
        match self.operations {
            Some(operations) => table.whole(operations),
            None => table.text(""),
        };
        table.end_row();
    }
}
