//! Records of a block's members, on their way into the reductions.

use leafwise_core::SolverStatistics;

use super::clock::window;
use super::plan::ComposedEnsemble;
use super::section::MemberCrossings;
use super::statistics::{MemberFailure, Reductions};
use super::tree::Tree;

/// Record of the members of a block: observables, deviations, states, failures, stops and crossings. Lists of numbers are structures
/// of arrays over the lanes.
#[derive(Default)]
pub(super) struct Record {
    pub first: u64,
    pub lanes: usize,
    /// Observables at each time.
    pub samples: Vec<f64>,
    /// The invariants' largest deviations in each window.
    pub windows: Vec<f64>,
    /// The invariants at the initial states.
    pub initial: Vec<f64>,
    pub initial_states: Vec<f64>,
    /// Last states.
    pub states: Vec<f64>,
    pub parameters: Vec<f64>,
    pub failures: Vec<Option<MemberFailure>>,
    /// Where the scene's condition has ended members.
    pub stops: Vec<Option<MemberStop>>,
    pub crossings: Vec<MemberCrossings>,
    pub statistics: SolverStatistics,
}

/// Where a condition has ended a member.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MemberStop {
    /// Its mark on the way: that of the step, or of the time; 0 where it holds at the initial state.
    pub mark: f64,
    /// The time.
    pub time: f64,
    /// The observables there.
    pub row: Vec<f64>,
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

    /// One lane of a structure of arrays.
    pub fn own<'a>(&self, values: &'a [f64], lane: usize) -> impl Iterator<Item = f64> + use<'a> {
        values.iter().skip(lane).step_by(self.lanes).copied()
    }

    /// The observables of a lane at the end.
    pub fn last_sample(&self, lane: usize, observables: usize) -> impl Iterator<Item = f64> {
        let from = self.samples.len() - observables * self.lanes;
        let stop = self.stops[lane].as_ref();
        let stopped = stop.into_iter().flat_map(|stop| stop.row.iter().copied());
        let last = self.own(&self.samples[from..], lane);
        stopped.chain(last.take(if stop.is_some() { 0 } else { observables }))
    }

    /// The largest deviation of each invariant of a lane.
    pub fn largest_deviations(&self, lane: usize) -> impl Iterator<Item = f64> + '_ {
        let invariants = self.initial.len() / self.lanes;
        let windows = self.windows.len() / self.initial.len().max(1);
        let value = move |window: usize, at: usize| {
            self.windows[(window * invariants + at) * self.lanes + lane]
        };
        (0..invariants).map(move |at| {
            (0..windows).fold(0.0, |largest: f64, window| largest.max(value(window, at)))
        })
    }

    /// Takes the members in, one after the other.
    pub fn fold(&self, ensemble: &ComposedEnsemble, into: &mut Tree) {
        into.add_work(self.statistics);
        let (windows, losses) = (ensemble.window_ends(), ensemble.loss_ends());
        for lane in 0..self.lanes {
            into.take(|into| self.fold_lane(ensemble, (&windows, &losses), lane, into));
        }
    }

    fn fold_lane(
        &self,
        ensemble: &ComposedEnsemble,
        (windows, losses): (&[f64], &[f64]),
        lane: usize,
        into: &mut Reductions,
    ) {
        let (lanes, sampled) = (self.lanes, &ensemble.clock.samples);
        let (columns, invariants) = (ensemble.columns.len(), ensemble.course.invariants.count());
        if let Some(failure) = self.failures[lane].clone() {
            into.push_failure(failure);
            return;
        }
        let member = self.first + lane as u64;
        let own = |values: &'_ [f64], at: usize| values[at * lanes + lane];
        let stop = self.stops[lane].as_ref();
        if let Some(stop) = stop {
            into.stopped += 1;
            into.losses[window(losses, stop.mark)] += 1;
        }
        // What lies before the place where it has ended.
        let is_before = |mark: f64| stop.is_none_or(|stop| mark < stop.mark);
        let mut samples = self.own(&self.samples, lane);
        let rows = into.summaries.chunks_exact_mut(columns.max(1));
        for (row, mark) in rows.zip(sampled) {
            for (summary, value) in row.iter_mut().zip(samples.by_ref()) {
                if is_before(*mark) {
                    summary.push(value, member);
                }
            }
        }
        let mut deviations = self.own(&self.windows, lane);
        let begins = std::iter::once(&0.0).chain(windows);
        let rows = into.windows.chunks_exact_mut(invariants.max(1));
        for (row, begin) in rows.zip(begins) {
            for (deviation, value) in row.iter_mut().zip(deviations.by_ref()) {
                if is_before(*begin) {
                    deviation.push(value, member);
                }
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
