//! Records of the members of a block: observables, deviations, crossings and ends.

use std::path::Path;

use leafwise_core::walk::column;
use leafwise_core::{BuildError, SolverStatistics};
use leafwise_walk::{At, Ended, FunctionValues, Look, Why};

use super::begun::Begun;
use super::clock::window;
use super::plan::{Column, ComposedEnsemble};
use super::record::{MemberStop, Record};
use super::section::MemberCrossings;
use super::statistics::MemberFailure;
use crate::{Failure, RunError};

/// Observables, deviations of invariants, crossings and ends of a block's members.
pub(super) struct MemberRecords<'a> {
    ensemble: &'a ComposedEnsemble,
    directory: &'a Path,
    record: Record,
    /// In all lanes.
    invariants: FunctionValues,
    formulas: FunctionValues,
    /// The indicators of chaos of all lanes after the last step.
    indicators: Vec<f64>,
    /// In one lane: one for all where they have the same parameters.
    rows: Vec<Option<[FunctionValues; 2]>>,
    /// Origins that H + e is measured from, beside a pace.
    origins: Vec<f64>,
    /// The next sample after a number of steps.
    next: usize,
    /// The deviations in the window that each lane is in.
    deviations: Vec<f64>,
    /// That window, where lanes are in windows of their own; `None` once it has ended: the lane goes on as a copy of others.
    window: Vec<Option<usize>>,
    /// The window that lanes are in together, where all make the same steps.
    common: usize,
    window_ends: Vec<f64>,
}

impl<'a> MemberRecords<'a> {
    /// The initial states recorded; `initial` are the invariants and the indicators of chaos there.
    pub fn new(
        ensemble: &'a ComposedEnsemble,
        directory: &'a Path,
        begun: Begun,
        initial: [&[f64]; 2],
    ) -> Result<Self, BuildError> {
        let (lanes, parameters) = (begun.members.len(), &begun.parameters);
        let mut records = Self {
            invariants: ensemble.course.invariants.values(lanes, parameters)?,
            formulas: ensemble.formulas.values(lanes, parameters)?,
            indicators: Vec::new(),
            rows: Vec::new(),
            origins: Vec::new(),
            next: 0,
            deviations: vec![0.0; ensemble.course.invariants.count() * lanes],
            window: vec![Some(0); lanes],
            common: 0,
            window_ends: ensemble.window_ends(),
            record: Record::default(),
            ensemble,
            directory,
        };
        records.begin(begun, initial);
        Ok(records)
    }

    /// The same of other members in as many lanes, behind those that have been [handed over](Self::finish).
    pub fn start_again(&mut self, begun: Begun, initial: [&[f64]; 2]) -> Result<(), BuildError> {
        self.invariants.set_parameters(&begun.parameters)?;
        self.formulas.set_parameters(&begun.parameters)?;
        self.deviations.fill(0.0);
        self.window.fill(Some(0));
        (self.next, self.common) = (0, 0);
        self.begin(begun, initial);
        Ok(())
    }

    fn begin(&mut self, begun: Begun, [initial, indicators]: [&[f64]; 2]) {
        let (ensemble, shape) = (self.ensemble, self.ensemble.shape());
        let lanes = begun.members.len();
        let differ = !ensemble.population.varied().is_empty();
        if differ || self.rows.is_empty() {
            self.rows.clear();
            let count = if differ { lanes } else { 1 };
            self.rows.resize_with(count, || None);
        }
        // H + e is measured from e at the beginning.
        self.origins.clear();
        if ensemble.run.pace().is_some() {
            let states = (0..lanes).map(|lane| column(&begun.states, lane, lanes));
            let origins = states.filter_map(|state| ensemble.origin(&state));
            self.origins.extend(origins);
        }
        self.invariants.measure_from(&self.origins);
        self.record = Record {
            first: begun.members[0],
            lanes,
            samples: vec![0.0; shape.times * shape.observables * lanes],
            windows: vec![0.0; shape.windows * shape.invariants * lanes],
            initial: initial.to_vec(),
            states: begun.drawn.clone(),
            initial_states: begun.drawn,
            parameters: begun.parameters,
            failures: begun.failures,
            stops: vec![None; lanes],
            crossings: (0..lanes).map(|_| MemberCrossings::default()).collect(),
            statistics: SolverStatistics::default(),
        };
        self.take_indicators(indicators);
        self.take_sample(&begun.states, Some(initial));
    }

    /// Takes in the observables of all members after a number of steps, with the invariants there where they are known.
    fn take_sample(&mut self, states: &[f64], invariants: Option<&[f64]>) {
        let lanes = self.record.lanes;
        let invariants = invariants.unwrap_or_else(|| self.invariants.at(states));
        let formulas = self.formulas.at(states);
        let size = self.ensemble.columns.len() * lanes;
        let row = &mut self.record.samples[self.next * size..][..size];
        for (values, column) in row.chunks_exact_mut(lanes).zip(&self.ensemble.columns) {
            let (all, at) = match column {
                Column::Invariant(at) => (invariants, at),
                Column::Recorded(at) => (formulas, at),
                Column::Indicator(at) => (&self.indicators[..], at),
            };
            values.copy_from_slice(&all[at * lanes..][..lanes]);
        }
        self.next += 1;
    }

    fn take_indicators(&mut self, indicators: &[f64]) {
        self.indicators.clear();
        self.indicators.extend_from_slice(indicators);
    }

    /// Hands over what the members leave behind, with the solver's statistics. Crossings of failed members are left out.
    pub fn finish(&mut self, statistics: SolverStatistics) -> Record {
        let mut record = std::mem::take(&mut self.record);
        record.statistics = statistics;
        for (failure, crossings) in record.failures.iter().zip(&mut record.crossings) {
            if failure.is_some() {
                crossings.clear();
            }
        }
        record
    }

    /// Writes the observables of a member at a state into the sample with this number.
    fn put_sample(&mut self, lane: usize, number: usize, state: &[f64]) -> Result<(), BuildError> {
        let row = self.row(lane, state)?;
        let from = number * self.ensemble.columns.len();
        for (value, place) in row.into_iter().zip(from..) {
            self.record.samples[place * self.record.lanes + lane] = value;
        }
        Ok(())
    }

    /// The observables of a member at a state.
    fn row(&mut self, lane: usize, state: &[f64]) -> Result<Vec<f64>, BuildError> {
        let at = lane.min(self.rows.len() - 1);
        let ensemble = self.ensemble;
        let slot = &mut self.rows[at];
        if slot.is_none() {
            let parameters = column(&self.record.parameters, lane, self.record.lanes);
            let own = [&ensemble.course.invariants, &ensemble.formulas];
            let [invariants, formulas] = own.map(|of| of.values(1, &parameters));
            *slot = Some([invariants?, formulas?]);
        }
        let [invariants, formulas] = slot.as_mut().expect("it was made above");
        invariants.measure_from(self.origins.get(lane..=lane).unwrap_or_default());
        let (invariants, formulas) = (invariants.at(state), formulas.at(state));
        let value = |column: &Column| match *column {
            Column::Invariant(at) => invariants[at],
            Column::Recorded(at) => formulas[at],
            Column::Indicator(at) => self.indicators[at * self.record.lanes + lane],
        };
        Ok(ensemble.columns.iter().map(value).collect())
    }

    /// Puts the deviations of lanes away that have come to another window with the last step.
    fn open_windows(&mut self, at: At<'_>) {
        let (ensemble, lanes) = (self.ensemble, self.record.lanes);
        if !ensemble.clock.is_of_time {
            let now = window(&self.window_ends, at.steps as f64);
            if now != self.common {
                self.put_all_away();
                self.common = now;
            }
            return;
        }
        for lane in 0..lanes {
            let Some(present) = self.window[lane] else {
                continue;
            };
            let state = column(at.state, lane, lanes);
            let time = ensemble.course.time(at.steps, &state);
            let now = window(&self.window_ends, ensemble.clock.mark(at.steps, time));
            if now != present {
                self.put_away(lane);
                self.window[lane] = Some(now);
            }
        }
    }

    /// Writes the deviations of all lanes into the window that they are in together.
    fn put_all_away(&mut self) {
        let size = self.deviations.len();
        if self.window.iter().all(Option::is_some) {
            let windows = &mut self.record.windows;
            if let Some(place) = windows.get_mut(self.common * size..(self.common + 1) * size) {
                place.copy_from_slice(&self.deviations);
                self.deviations.fill(0.0);
            }
            return;
        }
        for lane in 0..self.record.lanes {
            self.put_away(lane);
        }
    }

    /// Writes a lane's deviations into the window it is in.
    fn put_away(&mut self, lane: usize) {
        let Some(own) = self.window[lane] else {
            return;
        };
        let window = match self.ensemble.clock.is_of_time {
            true => own,
            false => self.common,
        };
        let (lanes, size) = (self.record.lanes, self.deviations.len());
        let windows = &mut self.record.windows;
        let Some(place) = windows.get_mut(window * size..(window + 1) * size) else {
            return;
        };
        for at in (lane..size).step_by(lanes) {
            place[at] = std::mem::take(&mut self.deviations[at]);
        }
    }

    /// Takes in what the walk of the block comes to.
    pub fn take(&mut self, look: Look<'_>) -> Result<(), RunError> {
        match look {
            Look::Made(at) => {
                self.take_indicators(at.indicators);
                Ok(())
            }
            Look::Steps(steps) => {
                let count = self.record.initial.len();
                for k in 0..steps.count {
                    let values: Vec<f64> = (0..count).map(|i| steps.invariant(i)[k]).collect();
                    let values = steps.is_looked_at(k).then_some(&values[..]);
                    self.take_step(steps.at(k), values, true);
                }
                Ok(())
            }
            Look::Step {
                at,
                invariants,
                goes_on,
            } => {
                self.take_step(at, invariants, goes_on);
                Ok(())
            }
            Look::Sample {
                lane,
                number,
                state,
                ..
            } => {
                let number = usize::try_from(number).unwrap_or(usize::MAX);
                Ok(self.put_sample(lane, number, state)?)
            }
            Look::Crossing {
                lane, time, state, ..
            } => {
                let recorded = self.ensemble.run.plan.states.coordinates();
                let mut row: Vec<f64> = recorded.map(|at| state[at]).collect();
                row.extend(self.row(lane, state)?);
                let member = self.record.first + lane as u64;
                let own = (self.directory, member);
                self.record.crossings[lane].push(own, time, row.into_iter())
            }
            Look::Ended { lane, ended } => self.take_end(lane, ended),
        }
    }

    fn take_step(&mut self, at: At<'_>, invariants: Option<&[f64]>, goes_on: bool) {
        if let Some(values) = invariants {
            self.open_windows(at);
            self.take_deviations(values);
        }
        let clock = &self.ensemble.clock;
        let mark = at.steps as f64;
        if goes_on && !clock.is_of_time && clock.samples.get(self.next) == Some(&mark) {
            self.take_sample(at.state, invariants);
        }
    }

    fn take_deviations(&mut self, values: &[f64]) {
        let largest = self.deviations.iter_mut();
        for ((largest, value), initial) in largest.zip(values).zip(&self.record.initial) {
            let deviation = (value - initial).abs();
            *largest = if deviation > *largest {
                deviation
            } else {
                *largest
            };
        }
    }

    fn take_end(&mut self, lane: usize, ended: &Ended) -> Result<(), RunError> {
        self.put_away(lane);
        self.window[lane] = None;
        let clock = &self.ensemble.clock;
        match &ended.why {
            Why::Failed(fault) => {
                let failure = Failure::of(fault, ended, &self.ensemble.run);
                self.record.failures[lane] = Some(MemberFailure {
                    member: self.record.first + lane as u64,
                    step: failure.step,
                    time: failure.time,
                    message: failure.message,
                    state: failure.state,
                });
            }
            Why::Stopped | Why::Event(_) => {
                self.record.stops[lane] = Some(MemberStop {
                    mark: clock.mark(ended.steps, ended.time),
                    time: ended.time,
                    row: self.row(lane, &ended.state)?,
                });
            }
            Why::Done if clock.is_of_time => {
                self.put_sample(lane, clock.samples.len() - 1, &ended.state)?;
            }
            Why::Done => {}
        }
        let places = self.record.states.iter_mut().skip(lane);
        let places = places.step_by(self.record.lanes).zip(&ended.state);
        places.for_each(|(place, value)| *place = *value);
        Ok(())
    }
}
