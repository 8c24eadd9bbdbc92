//! A block of members, side by side, from their initial states to the end.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use leafwise_core::{SideBySide, SolverStatistics};
use leafwise_scene::compose::{ParameterDomain, is_same_time};

use super::clock::window;
use super::observers::ObservableEvaluator;
use super::plan::{Column, ComposedEnsemble};
use super::record::Record;
use super::section::MemberCrossings;
use super::statistics::MemberFailure;
use super::watch::{Found, MemberSample, MemberStop, Watch, column};
use crate::invariants::outside;
use crate::{Failure, RunError};

/// Coordinates stepped between two looks at the flag: about a millisecond's work.
const COORDINATES_A_LOOK: usize = 4096;

/// What a block tells and is told while it runs.
#[derive(Debug, Default)]
pub(super) struct Signals {
    /// Steps of all members.
    pub steps: AtomicU64,
    /// Whether blocks are to stop where they are.
    pub stop: AtomicBool,
}

/// Steps the members `first .. first + lanes`; `None` where it was told to stop.
///
/// # Errors
/// [`RunError`] where an observer cannot be made, or crossings cannot be put aside in the directory.
pub(super) fn run(
    ensemble: &ComposedEnsemble,
    directory: &Path,
    (first, lanes): (u64, usize),
    signals: &Signals,
) -> Result<Option<Record>, RunError> {
    let mut block = Block::new(ensemble, directory, first, lanes)?;
    let total = ensemble.run.plan.steps;
    let stride = (COORDINATES_A_LOOK / (lanes * ensemble.population.dimension())).max(1) as u64;
    block.start()?;
    let (mut steps, mut shown) = (0, 0);
    while steps < total && block.integrator.living() > 0 {
        if signals.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let until = total.min(steps.saturating_add(stride));
        while steps < until && block.integrator.living() > 0 {
            steps += 1;
            block.step(steps)?;
        }
        // Members that have ended count as those that go on; where steps are not counted, each is one.
        let is_over = block.integrator.living() == 0;
        let made = match ensemble.steps() {
            Some(all) if is_over => all,
            Some(_) => steps,
            None => u64::from(is_over),
        };
        signals
            .steps
            .fetch_add((made - shown) * lanes as u64, Ordering::Relaxed);
        shown = made;
    }
    Ok(Some(block.finish()?))
}

struct Block<'a> {
    ensemble: &'a ComposedEnsemble,
    integrator: SideBySide,
    invariants: ObservableEvaluator<'a>,
    formulas: ObservableEvaluator<'a>,
    watch: Watch<'a>,
    record: Record,
    /// Which sample comes next, for each lane.
    next: Vec<usize>,
    /// The deviations in the window that each lane is in.
    deviations: Vec<f64>,
    /// That window; `None` once it has ended: the lane goes on as a copy of others.
    window: Vec<Option<usize>>,
    window_ends: Vec<f64>,
}

impl<'a> Block<'a> {
    fn new(
        ensemble: &'a ComposedEnsemble,
        directory: &Path,
        first: u64,
        lanes: usize,
    ) -> Result<Self, RunError> {
        let plan = &ensemble.run.plan;
        let shape = ensemble.shape();
        let mut failures: Vec<Option<MemberFailure>> = (0..lanes).map(|_| None).collect();
        let mut ends = vec![None; lanes];
        let (mut states, mut initial_states) = (Vec::new(), Vec::new());
        let mut parameters = Vec::new();
        let domain = ParameterDomain::of(&ensemble.run.system, ensemble.run.method.noise());
        for lane in 0..lanes {
            let member = first + lane as u64;
            let drawn = ensemble.population.drawn(member);
            let begins = drawn.begins.map_err(|reason| reason.to_string());
            let begins = begins.and_then(|()| {
                let inside = domain.check(&drawn.parameters);
                inside.map_err(|reason| reason.to_string())
            });
            match begins {
                Ok(()) => states.push(drawn.state.clone()),
                Err(message) => {
                    failures[lane] = Some(MemberFailure {
                        member,
                        step: 0,
                        time: 0.0,
                        message,
                        state: ensemble.run.own(&drawn.state).to_vec(),
                    });
                    ends[lane] = Some(drawn.state.clone());
                    // The lane rests where evaluations have values.
                    states.push(plan.initial.clone());
                }
            }
            initial_states.push(drawn.state);
            parameters.push(drawn.parameters);
        }
        let (initial, values) = (interleaved(&states), interleaved(&parameters));
        let map = ensemble.run.method.map();
        let mut integrator = SideBySide::new(map, lanes, &values, plan.epsilon, plan.h, &initial);
        let members: Vec<u64> = (first..first + lanes as u64).collect();
        integrator.follow(&members);
        // H + e is measured from e at the beginning.
        let origins: Vec<f64> = states
            .iter()
            .filter_map(|state| ensemble.origin(state))
            .collect();
        let mut invariants = ensemble.invariants.evaluator(lanes, &values)?;
        invariants.measure_from(&origins);
        Ok(Self {
            formulas: ensemble.formulas.evaluator(lanes, &values)?,
            watch: Watch::new(ensemble, &parameters, &values, &origins)?,
            next: vec![0; lanes],
            deviations: vec![0.0; shape.invariants * lanes],
            window: vec![Some(0); lanes],
            invariants,
            integrator,
            record: Record {
                first,
                lanes,
                samples: vec![0.0; shape.times * shape.observables * lanes],
                windows: vec![0.0; shape.windows * shape.invariants * lanes],
                initial: Vec::new(),
                initial_states,
                states,
                parameters,
                failures,
                ends,
                stops: vec![None; lanes],
                crossings: (first..first + lanes as u64)
                    .map(|member| MemberCrossings::new(directory, member))
                    .collect(),
                statistics: SolverStatistics::default(),
            },
            window_ends: ensemble.window_ends(),
            ensemble,
        })
    }

    /// Takes in the initial states.
    fn start(&mut self) -> Result<(), RunError> {
        for lane in 0..self.record.lanes {
            if self.record.failures[lane].is_some() {
                self.integrator.rest(lane);
            }
        }
        self.record.initial = self.invariants.at(self.integrator.state()).to_vec();
        self.check_invariants(0);
        if !self.watch.is_blind() {
            let found = self.watch.begin(&self.integrator)?;
            self.take_stops(found);
            self.close_windows();
        }
        self.take_sample();
        Ok(())
    }

    fn step(&mut self, steps: u64) -> Result<(), RunError> {
        let is_blind = self.watch.is_blind();
        if !is_blind {
            self.watch.keep(&self.integrator);
        }
        let (record, ensemble) = (&mut self.record, self.ensemble);
        let mut any = false;
        let mut errors = Vec::new();
        self.integrator.step(|lane, error| {
            any = true;
            errors.push((lane, error));
        });
        if any {
            for (lane, error) in errors {
                let (made, state) = self.integrator.last(lane);
                let time = ensemble.time(made, &state);
                let state = ensemble.run.own(&state);
                let mut failure = Failure::of_step(&error, made, time, state);
                failure.of_parts(&ensemble.run.plan.parts);
                record.failures[lane] = Some(told(record.first + lane as u64, failure));
            }
        }
        let mut takes_part: Vec<bool> = Vec::new();
        if !is_blind {
            for (lane, failure) in self.watch.paces(&self.integrator, steps)? {
                // The state that was reached is none of the motion's.
                self.record.ends[lane] = Some(failure.state.clone());
                self.integrator.rest(lane);
                self.fail(lane, failure);
            }
            let lives = |lane| self.integrator.lives(lane);
            takes_part = (0..self.record.lanes).map(lives).collect();
            let found = self.watch.stops(&self.integrator, steps)?;
            self.take_stops(found);
        }
        self.open_windows(steps);
        let is_last = steps == ensemble.run.plan.steps;
        if steps.is_multiple_of(ensemble.drift_every) || is_last {
            self.take_drift(steps);
        }
        if !is_blind {
            self.take_crossings(steps, &takes_part)?;
        }
        if ensemble.clock.is_of_time {
            self.take_times(steps, &takes_part)?;
        } else if ensemble.clock.samples.get(self.next[0]) == Some(&(steps as f64)) {
            self.take_sample();
        }
        if !is_blind {
            self.close_windows();
        }
        Ok(())
    }

    /// Ends the members that the condition has ended, or that it has no value for.
    fn take_stops(&mut self, found: Found<MemberStop>) {
        for (lane, ended) in found {
            self.integrator.rest(lane);
            match ended {
                Ok(stop) => self.record.stops[lane] = Some(stop),
                Err(failure) => self.fail(lane, failure),
            }
        }
    }

    fn take_crossings(&mut self, steps: u64, takes_part: &[bool]) -> Result<(), RunError> {
        let (watch, record) = (&mut self.watch, &mut self.record);
        let (stops, failures) = (&record.stops, &record.failures);
        let found = watch.crossings(
            &self.integrator,
            steps,
            |lane| takes_part[lane] && failures[lane].is_none(),
            |lane| stops[lane].as_ref().map(|stop| stop.time),
        )?;
        for (lane, crossing) in found {
            let member = self.record.first + lane as u64;
            match crossing {
                Ok((time, row)) => {
                    self.record.crossings[lane].push(member, time, row.into_iter())?;
                }
                Err(failure) => self.end_as_failed(lane, failure),
            }
        }
        Ok(())
    }

    fn fail(&mut self, lane: usize, failure: Failure) {
        let member = self.record.first + lane as u64;
        self.record.failures[lane] = Some(told(member, failure));
    }

    /// The mark of a lane after so many steps.
    fn mark(&self, lane: usize, steps: u64) -> f64 {
        let clock = &self.ensemble.clock;
        if !clock.is_of_time {
            return steps as f64;
        }
        let state = column(self.integrator.state(), lane, self.record.lanes);
        clock.mark(steps, self.ensemble.time(steps, &state))
    }

    /// Puts the deviations of lanes away that have come to another window with the last step.
    fn open_windows(&mut self, steps: u64) {
        let lanes = match self.ensemble.clock.is_of_time {
            true => self.record.lanes,
            // All go together.
            false
                if self
                    .window_ends
                    .binary_search_by(|end| end.total_cmp(&(steps as f64 - 1.0)))
                    .is_ok() =>
            {
                self.record.lanes
            }
            false => 0,
        };
        for lane in 0..lanes {
            let Some(present) = self.window[lane] else {
                continue;
            };
            let now = window(&self.window_ends, self.mark(lane, steps));
            if now != present {
                self.put_away(lane);
                self.window[lane] = Some(now);
            }
        }
    }

    /// Ends the windows of members that have just ended.
    fn close_windows(&mut self) {
        for lane in 0..self.record.lanes {
            if !self.integrator.lives(lane) {
                self.put_away(lane);
                self.window[lane] = None;
            }
        }
    }

    /// Writes a lane's deviations into the window it is in.
    fn put_away(&mut self, lane: usize) {
        let Some(window) = self.window[lane] else {
            return;
        };
        let (lanes, size) = (self.record.lanes, self.deviations.len());
        let Some(place) = self
            .record
            .windows
            .get_mut(window * size..(window + 1) * size)
        else {
            return;
        };
        for at in (lane..size).step_by(lanes) {
            place[at] = std::mem::take(&mut self.deviations[at]);
        }
    }

    fn take_drift(&mut self, steps: u64) {
        let values = self.invariants.at(self.integrator.state());
        let mut sum = 0.0;
        let largest = self.deviations.iter_mut();
        for ((largest, value), initial) in largest.zip(values).zip(&self.record.initial) {
            let deviation = (value - initial).abs();
            *largest = if deviation > *largest {
                deviation
            } else {
                *largest
            };
            sum += deviation;
        }
        if !sum.is_finite() {
            self.check_invariants(steps);
        }
    }

    /// Ends the members that have left the energy's domain.
    fn check_invariants(&mut self, steps: u64) {
        let names = self.ensemble.invariant_names();
        let lanes = self.record.lanes;
        let energies = |state: &[f64], is_nan: &mut Vec<bool>| {
            is_nan.extend(
                self.invariants.at(state)[..lanes]
                    .iter()
                    .map(|v| v.is_nan()),
            );
        };
        let outside = outside(self.integrator.state(), lanes, energies);
        for (lane, is_outside) in outside.into_iter().enumerate() {
            if !is_outside || !self.integrator.lives(lane) {
                continue;
            }
            self.integrator.rest(lane);
            let (_, state) = self.integrator.last(lane);
            let time = self.ensemble.time(steps, &state);
            let state = self.ensemble.run.own(&state);
            let failure = Failure::of_observable(names[0], steps, time, state);
            let member = self.record.first + lane as u64;
            self.record.failures[lane] = Some(told(member, failure));
        }
    }

    fn take_sample(&mut self) {
        let lanes = self.record.lanes;
        let state = self.integrator.state();
        let invariants = self.invariants.at(state);
        let formulas = self.formulas.at(state);
        let size = self.ensemble.columns.len() * lanes;
        let row = &mut self.record.samples[self.next[0] * size..][..size];
        for (values, column) in row.chunks_exact_mut(lanes).zip(&self.ensemble.columns) {
            let (all, at) = match column {
                Column::Invariant(at) => (invariants, at),
                Column::Formula(at) => (formulas, at),
            };
            values.copy_from_slice(&all[at * lanes..][..lanes]);
        }
        self.next.iter_mut().for_each(|next| *next += 1);
    }

    /// Takes in the states at the times that members have passed in the last step; those that have come to the end rest.
    fn take_times(&mut self, steps: u64, takes_part: &[bool]) -> Result<(), RunError> {
        let (ensemble, lanes) = (self.ensemble, self.record.lanes);
        let (clock, columns) = (&ensemble.clock, ensemble.columns.len());
        for lane in 0..lanes {
            let stop = self.record.stops[lane].as_ref().map(|stop| stop.mark);
            let present = self.mark(lane, steps);
            let is_passed = |mark: f64| {
                let is_met = ensemble.run.pace().is_none() && is_same_time(present, mark);
                (is_met || present >= mark) && stop.is_none_or(|stop| mark < stop)
            };
            while takes_part[lane] && self.record.failures[lane].is_none() {
                let next = self.next[lane];
                let Some(mark) = clock.samples.get(next).filter(|mark| is_passed(**mark)) else {
                    break;
                };
                let at = (steps, clock.time(*mark));
                match self.watch.sample(&self.integrator, lane, at)? {
                    Ok(MemberSample { state, row }) => {
                        for (value, place) in row.into_iter().zip((next * columns)..) {
                            self.record.samples[place * lanes + lane] = value;
                        }
                        self.next[lane] += 1;
                        if self.next[lane] == clock.samples.len() {
                            self.integrator.rest(lane);
                            self.record.ends[lane] = Some(state);
                        }
                    }
                    Err(failure) => self.end_as_failed(lane, failure),
                }
            }
        }
        Ok(())
    }

    /// Ends a member whose step cannot be divided.
    fn end_as_failed(&mut self, lane: usize, failure: Failure) {
        self.integrator.rest(lane);
        self.record.stops[lane] = None;
        self.fail(lane, failure);
    }

    fn finish(mut self) -> Result<Record, RunError> {
        self.record.statistics = self.integrator.statistics();
        for lane in 0..self.record.lanes {
            self.put_away(lane);
        }
        for (lane, state) in self.record.states.iter_mut().enumerate() {
            *state = match (&self.record.stops[lane], self.record.ends[lane].take()) {
                (Some(stop), _) => stop.state.clone(),
                (None, Some(end)) => end,
                (None, None) => self.integrator.last(lane).1,
            };
        }
        for lane in 0..self.record.lanes {
            match self.record.failures[lane] {
                Some(_) => self.record.crossings[lane].clear(),
                None => self.take_end_on_section(lane)?,
            }
        }
        Ok(self.record)
    }

    fn take_end_on_section(&mut self, lane: usize) -> Result<(), RunError> {
        let (steps, state) = (self.integrator.last(lane).0, &self.record.states[lane]);
        let Some(row) = self.watch.end_on_section(lane, steps, state)? else {
            return Ok(());
        };
        let member = self.record.first + lane as u64;
        let time = self.record.time(lane, self.ensemble.end());
        self.record.crossings[lane].push(member, time, row.into_iter())
    }
}

fn told(member: u64, failure: Failure) -> MemberFailure {
    MemberFailure {
        member,
        step: failure.step,
        time: failure.time,
        message: failure.message,
        state: failure.state,
    }
}

/// A structure of arrays of columns.
fn interleaved(columns: &[Vec<f64>]) -> Vec<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    let row = |i: usize| columns.iter().map(move |column| column[i]);
    (0..rows).flat_map(row).collect()
}
