//! A block of members, side by side, from their initial states to the end.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use leafwise_core::{SideBySide, SolverStatistics};

use super::observers::ObservableEvaluator;
use super::plan::{Column, ComposedEnsemble};
use super::population::NO_LEAF;
use super::section::MemberCrossings;
use super::statistics::{MemberFailure, Reductions};
use super::tree::Tree;
use super::watch::{Found, MemberStop, Watch};
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

/// What the members of a block leave behind.
pub(super) struct Record {
    first: u64,
    lanes: usize,
    /// Observables at each time, for each lane.
    samples: Vec<f64>,
    /// The invariants' largest deviations in each window, for each lane.
    windows: Vec<f64>,
    /// The invariants at the initial states.
    initial: Vec<f64>,
    /// Initial states, last states and parameters, lane after lane.
    pub initial_states: Vec<Vec<f64>>,
    pub states: Vec<Vec<f64>>,
    pub parameters: Vec<Vec<f64>>,
    failures: Vec<Option<MemberFailure>>,
    /// Where the scene's condition has ended members.
    pub stops: Vec<Option<MemberStop>>,
    pub crossings: Vec<MemberCrossings>,
    statistics: SolverStatistics,
}

/// How a member has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ended {
    Done,
    Stopped,
    Failed,
}

impl Ended {
    /// As a number.
    pub fn number(self) -> f64 {
        match self {
            Self::Done => 0.0,
            Self::Stopped => 1.0,
            Self::Failed => 2.0,
        }
    }

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Stopped => "stopped",
            Self::Failed => "failed",
        }
    }
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
    let mut steps = 0;
    while steps < total {
        if signals.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let until = total.min(steps + stride);
        let before = steps;
        while steps < until && block.integrator.living() > 0 {
            steps += 1;
            block.step(steps)?;
        }
        if block.integrator.living() == 0 {
            signals
                .steps
                .fetch_add((total - before) * lanes as u64, Ordering::Relaxed);
            break;
        }
        signals
            .steps
            .fetch_add((steps - before) * lanes as u64, Ordering::Relaxed);
    }
    Ok(Some(block.finish()))
}

struct Block<'a> {
    ensemble: &'a ComposedEnsemble,
    integrator: SideBySide,
    invariants: ObservableEvaluator<'a>,
    formulas: ObservableEvaluator<'a>,
    watch: Watch<'a>,
    /// The deviations in all windows of members that have ended: their lanes go on as copies of others.
    deviations: Vec<Option<Vec<f64>>>,
    record: Record,
    /// The time and the window to be filled next.
    sample: usize,
    window: usize,
    window_end: u64,
    sampled: Vec<u64>,
    window_ends: Vec<u64>,
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
        let (mut states, mut parameters) = (Vec::new(), Vec::new());
        for lane in 0..lanes {
            let member = first + lane as u64;
            let (state, own) = ensemble.population.draw(member).unwrap_or_else(|| {
                failures[lane] = Some(MemberFailure {
                    member,
                    step: 0,
                    time: 0.0,
                    message: NO_LEAF.to_owned(),
                    state: Vec::new(),
                });
                (plan.initial.clone(), ensemble.run.system.parameter_values())
            });
            states.push(state);
            parameters.push(own);
        }
        let (initial, values) = (interleaved(&states), interleaved(&parameters));
        let map = ensemble.run.method.map();
        let integrator = SideBySide::new(map, lanes, &values, plan.epsilon, plan.h, &initial);
        let window_ends = ensemble.window_ends();
        Ok(Self {
            invariants: ensemble.invariants.evaluator(lanes, &values)?,
            formulas: ensemble.formulas.evaluator(lanes, &values)?,
            watch: Watch::new(ensemble, &parameters, &values)?,
            deviations: vec![None; lanes],
            integrator,
            record: Record {
                first,
                lanes,
                samples: vec![0.0; shape.times * shape.observables * lanes],
                windows: vec![0.0; shape.windows * shape.invariants * lanes],
                initial: Vec::new(),
                initial_states: states.clone(),
                states,
                parameters,
                failures,
                stops: vec![None; lanes],
                crossings: (first..first + lanes as u64)
                    .map(|member| MemberCrossings::new(directory, member))
                    .collect(),
                statistics: SolverStatistics::default(),
            },
            sample: 0,
            window: 0,
            window_end: window_ends.first().copied().unwrap_or(0),
            sampled: ensemble.sampled_steps(),
            window_ends,
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
            self.keep_deviations();
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
                let state = ensemble.run.own(&state);
                let mut failure = Failure::of_step(&error, made, ensemble.time(made), state);
                failure.of_parts(&ensemble.run.plan.parts);
                record.failures[lane] = Some(told(record.first + lane as u64, failure));
            }
        }
        let takes_part: Vec<bool> = match is_blind {
            true => Vec::new(),
            false => (0..self.record.lanes)
                .map(|lane| self.integrator.lives(lane))
                .collect(),
        };
        if !is_blind {
            let found = self.watch.stops(&self.integrator, steps)?;
            self.take_stops(found);
        }
        let is_last = steps == ensemble.run.plan.steps;
        if steps.is_multiple_of(ensemble.drift_every) || is_last {
            self.take_drift(steps);
        }
        if !is_blind {
            self.take_crossings(steps, &takes_part)?;
            self.keep_deviations();
        }
        if self.sampled.get(self.sample) == Some(&steps) {
            self.take_sample();
        }
        if steps == self.window_end {
            self.window += 1;
            self.window_end = self.window_ends.get(self.window).copied().unwrap_or(0);
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
                Err(failure) => {
                    self.integrator.rest(lane);
                    self.record.stops[lane] = None;
                    self.fail(lane, failure);
                }
            }
        }
        Ok(())
    }

    fn fail(&mut self, lane: usize, failure: Failure) {
        let member = self.record.first + lane as u64;
        self.record.failures[lane] = Some(told(member, failure));
    }

    /// Keeps the deviations of members that have just ended.
    fn keep_deviations(&mut self) {
        let lanes = self.record.lanes;
        for (lane, kept) in self.deviations.iter_mut().enumerate() {
            if self.record.stops[lane].is_some() && kept.is_none() {
                let own = self.record.windows.iter().skip(lane).step_by(lanes);
                *kept = Some(own.copied().collect());
            }
        }
    }

    fn take_drift(&mut self, steps: u64) {
        let values = self.invariants.at(self.integrator.state());
        let size = values.len();
        let window = &mut self.record.windows[self.window * size..][..size];
        let mut sum = 0.0;
        for ((largest, value), initial) in window.iter_mut().zip(values).zip(&self.record.initial) {
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

    /// Ends the members whose energy or a Casimir has no finite value.
    fn check_invariants(&mut self, steps: u64) {
        let names = self.ensemble.invariant_names();
        let values = self.invariants.at(self.integrator.state());
        let lanes = self.record.lanes;
        for lane in 0..lanes {
            let mut own = values.iter().skip(lane).step_by(lanes);
            let Some(at) = own.position(|value| !value.is_finite()) else {
                continue;
            };
            if !self.integrator.lives(lane) {
                continue;
            }
            self.integrator.rest(lane);
            let (_, state) = self.integrator.last(lane);
            let time = self.ensemble.time(steps);
            let state = self.ensemble.run.own(&state);
            let failure = Failure::of_observable(names[at], steps, time, state);
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
        let row = &mut self.record.samples[self.sample * size..][..size];
        for (values, column) in row.chunks_exact_mut(lanes).zip(&self.ensemble.columns) {
            let (all, at) = match column {
                Column::Invariant(at) => (invariants, at),
                Column::Formula(at) => (formulas, at),
            };
            values.copy_from_slice(&all[at * lanes..][..lanes]);
        }
        self.sample += 1;
    }

    fn finish(mut self) -> Record {
        self.record.statistics = self.integrator.statistics();
        for (lane, state) in self.record.states.iter_mut().enumerate() {
            *state = match &self.record.stops[lane] {
                Some(stop) => stop.state.clone(),
                None => self.integrator.last(lane).1,
            };
            if self.record.failures[lane].is_some() {
                self.record.crossings[lane].clear();
            }
            // A member that never made a step deviates by nothing.
            let stopped = self.record.stops[lane].is_some();
            if stopped || self.deviations[lane].is_some() {
                let own = self.record.windows.iter_mut().skip(lane);
                let own = own.step_by(self.record.lanes).enumerate();
                let kept = self.deviations[lane].as_deref().unwrap_or(&[]);
                own.for_each(|(at, value)| *value = kept.get(at).copied().unwrap_or(0.0));
            }
        }
        self.record
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

impl Record {
    /// The members, their lanes, and how they have ended.
    pub fn members(&self) -> impl Iterator<Item = (u64, usize, Ended)> + '_ {
        (0..self.lanes).map(|lane| {
            let ended = match (&self.failures[lane], &self.stops[lane]) {
                (Some(_), _) => Ended::Failed,
                (None, Some(_)) => Ended::Stopped,
                (None, None) => Ended::Done,
            };
            (self.first + lane as u64, lane, ended)
        })
    }

    /// The time at which a lane's member has ended; `end` is that of the last step.
    pub fn time(&self, lane: usize, end: f64) -> f64 {
        let failed = self.failures[lane].as_ref().map(|failure| failure.time);
        let stopped = self.stops[lane].as_ref().map(|stop| stop.time);
        failed.or(stopped).unwrap_or(end)
    }

    /// The observables of a lane at the end.
    pub fn last_sample(&self, lane: usize, observables: usize) -> Vec<f64> {
        if let Some(stop) = &self.stops[lane] {
            return stop.row.clone();
        }
        let from = self.samples.len() - observables * self.lanes;
        let row = self.samples[from..].iter().skip(lane);
        row.step_by(self.lanes).copied().collect()
    }

    /// The largest deviation of each invariant of a lane.
    pub fn largest_deviations(&self, lane: usize) -> impl Iterator<Item = f64> + '_ {
        let invariants = self.initial.len() / self.lanes;
        let own = self.windows.iter().skip(lane).step_by(self.lanes);
        (0..invariants).map(move |at| {
            let windows = own.clone().skip(at).step_by(invariants);
            windows.fold(0.0, |largest: f64, deviation| largest.max(*deviation))
        })
    }

    /// Takes the members in, one after the other.
    pub fn fold(&self, ensemble: &ComposedEnsemble, into: &mut Tree) {
        into.add_work(self.statistics);
        let sampled = ensemble.sampled_steps();
        for lane in 0..self.lanes {
            into.take(|into| self.fold_lane(ensemble, &sampled, lane, into));
        }
    }

    fn fold_lane(
        &self,
        ensemble: &ComposedEnsemble,
        sampled: &[u64],
        lane: usize,
        into: &mut Reductions,
    ) {
        let (lanes, window) = (self.lanes, ensemble.window());
        let (columns, invariants) = (ensemble.columns.len(), ensemble.invariants.count());
        if let Some(failure) = self.failures[lane].clone() {
            into.push_failure(failure);
            return;
        }
        let member = self.first + lane as u64;
        let own = |values: &'_ [f64], at: usize| values[at * lanes + lane];
        let stop = self.stops[lane].as_ref();
        if let Some(stop) = stop {
            into.stopped += 1;
            into.losses[ensemble.loss_place(stop.step)] += 1;
        }
        // What lies before the step in which it has ended.
        let is_before = |step: u64| stop.is_none_or(|stop| step < stop.step);
        for (at, summary) in into.summaries.iter_mut().enumerate() {
            if is_before(sampled[at / columns]) {
                summary.push(own(&self.samples, at), member);
            }
        }
        for (at, deviation) in into.windows.iter_mut().enumerate() {
            if is_before((at / invariants) as u64 * window) {
                deviation.push(own(&self.windows, at), member);
            }
        }
        for (at, deviation) in self.largest_deviations(lane).enumerate() {
            let initial = own(&self.initial, at);
            into.whole[at].push(deviation, member);
            into.initial[at].push(initial, member);
            if initial != 0.0 {
                into.relative[at].push(deviation / initial.abs(), member);
            }
        }
    }
}
