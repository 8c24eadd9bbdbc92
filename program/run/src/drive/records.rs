//! Records of a run: rows of samples and crossings, windows of invariants, states that its method is judged at.

use leafwise_scene::compose::{ComposedRun, Observable, WIDEST_STATE};
use leafwise_walk::{Course, Ended, FunctionValues, Look, SampleTimes, Steps};

use crate::crossing::Crossing;
use crate::error::RunError;
use crate::invariants::Windows;
use crate::samples::Samples;
use crate::snapshots::{Snapshots, shown};
use crate::states::StateTable;
use crate::watch::Watch;

/// The tables of a run, and what is kept in memory beside them.
pub(super) struct Records<'a> {
    run: &'a ComposedRun,
    course: &'a Course,
    invariants: FunctionValues,
    formulas: FunctionValues,
    columns: Vec<Column>,
    row: Vec<f64>,
    shown: Vec<f64>,
    /// The invariants at one of many steps.
    values: Vec<f64>,
    /// The indicators of chaos after the last step.
    pub indicators: Vec<f64>,
    pub samples: Samples,
    /// States that are too wide for samples.
    pub states: Option<StateTable>,
    /// The rows of the scene's own section, which is the first event.
    pub crossings: Option<Samples>,
    /// The crossings of each of the other events.
    pub found: Vec<Vec<Crossing>>,
    pub windows: Windows,
    /// States that the method is judged at.
    pub watch: Watch,
    pub snapshots: Snapshots,
    /// The coordinates of a snapshot; none where samples hold the state.
    pictured: Vec<usize>,
    /// The number of steps to the last sample.
    pub last_sample: Option<u64>,
    /// For each formula, the samples at which it has no finite value.
    pub undefined: Vec<u64>,
    /// Evaluations of earlier sessions.
    pub before: u64,
}

/// Where a recorded value comes from.
#[derive(Clone, Copy)]
enum Column {
    Invariant(usize),
    Formula(usize),
    Coordinate(usize),
    Indicator(usize),
}

impl<'a> Records<'a> {
    /// Nothing recorded yet; `initial` are the invariants at the initial state.
    pub fn new(
        run: &'a ComposedRun,
        course: &'a Course,
        initial: &[f64],
        samples: Samples,
    ) -> Result<Self, RunError> {
        let parameters = run.system.parameter_values();
        let mut invariants = course.invariants.values(1, &parameters)?;
        if let Some(origin) = run.origin(&run.plan.initial) {
            invariants.measure_from(&[origin]);
        }
        let mut columns = Vec::with_capacity(run.plan.observables.len());
        let mut formula = 0;
        for observable in &run.plan.observables {
            columns.push(match observable {
                Observable::Invariant { index, .. } => Column::Invariant(*index),
                Observable::Formula { .. } => {
                    formula += 1;
                    Column::Formula(formula - 1)
                }
                Observable::Coordinate { index, .. } => Column::Coordinate(*index),
                Observable::Indicator { index, .. } => Column::Indicator(*index),
            });
        }
        let own = usize::from(run.plan.events.section.is_some());
        Ok(Self {
            invariants,
            formulas: run.recorded_functions()?.values(1, &parameters)?,
            row: vec![0.0; columns.len()],
            columns,
            shown: Vec::new(),
            values: Vec::new(),
            indicators: Vec::new(),
            samples,
            states: None,
            crossings: None,
            found: vec![Vec::new(); course.events.len() - own],
            windows: Windows::new(initial),
            watch: Watch::new(&run.plan.initial),
            snapshots: Snapshots::new(),
            pictured: match run.own(&run.plan.initial).len() > WIDEST_STATE {
                true => shown(&run.plan.sites),
                false => Vec::new(),
            },
            last_sample: None,
            undefined: vec![0; formula],
            before: 0,
            run,
            course,
        })
    }

    /// Records the state after so many steps, once.
    pub fn record(&mut self, steps: u64, time: f64, state: &[f64]) -> Result<(), RunError> {
        self.record_with(steps, time, state, None)
    }

    /// The same where the invariants there are known.
    fn record_with(
        &mut self,
        steps: u64,
        time: f64,
        state: &[f64],
        invariants: Option<&[f64]>,
    ) -> Result<(), RunError> {
        if self.last_sample == Some(steps) {
            return Ok(());
        }
        self.record_state(time, state, invariants)?;
        self.last_sample = Some(steps);
        Ok(())
    }

    /// Records the state at the end.
    pub fn record_end(&mut self, ended: &Ended) -> Result<(), RunError> {
        match ended.is_between {
            true => self.record_state(ended.time, &ended.state, None),
            false => self.record(ended.steps, ended.time, &ended.state),
        }
    }

    /// Records a state at its time.
    fn record_state(
        &mut self,
        time: f64,
        state: &[f64],
        invariants: Option<&[f64]>,
    ) -> Result<(), RunError> {
        self.fill_row(state, invariants);
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
        if !self.pictured.is_empty() {
            self.snapshots
                .push(&self.pictured, time, self.run.own(state));
        }
        Ok(())
    }

    /// The columns of a row behind its time: recorded coordinates in `shown`, observables in `row`.
    fn fill_row(&mut self, state: &[f64], invariants: Option<&[f64]>) {
        let invariants = invariants.unwrap_or_else(|| self.invariants.at(state));
        let formulas = self.formulas.at(state);
        for (value, column) in self.row.iter_mut().zip(&self.columns) {
            *value = match *column {
                Column::Invariant(index) => invariants[index],
                Column::Formula(index) => formulas[index],
                Column::Coordinate(index) => state[index],
                Column::Indicator(index) => self.indicators[index],
            };
        }
        self.shown.clear();
        if self.states.is_none() {
            let recorded = self.run.plan.states.coordinates();
            self.shown.extend(recorded.map(|at| state[at]));
        }
    }

    /// Whether the walk is at the end, which is recorded as the end, where that lies at a time.
    fn is_beyond(&self, steps: u64, time: f64) -> bool {
        let Some(until) = self.course.until else {
            return false;
        };
        match self.course.pace {
            Some(_) => !self.course.is_before(time, until),
            None => steps >= self.course.steps,
        }
    }

    /// Takes in what the walk comes to.
    pub fn take(&mut self, look: Look<'_>) -> Result<(), RunError> {
        match look {
            Look::Made(at) => {
                self.watch.take(at.state, at.steps, at.evaluations);
                self.indicators.clear();
                self.indicators.extend_from_slice(at.indicators);
            }
            Look::Step {
                at,
                invariants,
                goes_on,
            } => {
                if let Some(values) = invariants {
                    let evaluations = self.before + at.evaluations;
                    self.windows.push(values, at.time, || evaluations);
                }
                if let SampleTimes::Every(every) = self.course.samples
                    && goes_on
                    && at.steps.is_multiple_of(every)
                    && !self.is_beyond(at.steps, at.time)
                {
                    self.record_with(at.steps, at.time, at.state, invariants)?;
                }
            }
            Look::Steps(steps) => self.take_steps(steps)?,
            Look::Sample {
                time, state, steps, ..
            } => {
                self.record_state(time, state, None)?;
                self.last_sample = steps.or(self.last_sample);
            }
            Look::Crossing {
                event, time, state, ..
            } => self.take_crossing(event, time, state)?,
            Look::Ended { .. } => {}
        }
        Ok(())
    }

    /// Records what many steps have come to, then looks at all that were taken in together.
    fn take_steps(&mut self, steps: &Steps<'_>) -> Result<(), RunError> {
        let recorded = self.record_steps(steps);
        let taken = 0..steps.taken.get();
        if !taken.is_empty() {
            self.watch.take_steps(steps, taken.clone());
            self.windows.push_steps(steps, taken, self.before);
        }
        recorded
    }

    fn record_steps(&mut self, steps: &Steps<'_>) -> Result<(), RunError> {
        if let SampleTimes::Every(every) = self.course.samples {
            let as_many = |steps: u64| usize::try_from(steps).unwrap_or(usize::MAX);
            let first = as_many(every - steps.before % every);
            for made in (first..=steps.count).step_by(as_many(every)) {
                let at = steps.at(made - 1);
                if !self.is_beyond(at.steps, at.time) {
                    let count = self.windows.initial.len();
                    let mut values = std::mem::take(&mut self.values);
                    values.clear();
                    values.extend((0..count).map(|i| steps.invariant(i)[made - 1]));
                    let recorded = self.record_with(at.steps, at.time, at.state, Some(&values));
                    self.values = values;
                    recorded?;
                }
                steps.taken.set(made);
            }
        }
        steps.taken.set(steps.count);
        Ok(())
    }

    fn take_crossing(&mut self, event: usize, time: f64, state: &[f64]) -> Result<(), RunError> {
        let own = usize::from(self.run.plan.events.section.is_some());
        if event >= own {
            let state = self.run.own(state).to_vec();
            self.found[event - own].push(Crossing { time, state });
            return Ok(());
        }
        self.fill_row(state, None);
        match &mut self.crossings {
            Some(crossings) => crossings.push(time, &self.shown, &self.row),
            None => Ok(()),
        }
    }
}
