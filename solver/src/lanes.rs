//! Trajectories in lanes: each by itself, or several in lockstep.

use super::{SolverStatistics, Stepper};
use crate::error::StepError;

/// The most trajectories in lockstep: what they hold stays in the fastest caches.
const MOST_TOGETHER: usize = 64;

/// Steps of one trajectory or of several in lockstep, for fixed parameters and step sizes: a stepper's
/// mathematics. In lockstep each evaluation is one for all that need it.
///
/// Arrays hold the trajectories one after the other, d numbers each. What a step writes for a trajectory
/// depends on that one alone, to the bit.
pub trait Trajectories: Send {
    /// Φ(x + low) − (x + low) of every trajectory, where `low` carries what the compensated state holds beyond a
    /// double. The reports in `taken` say of each how it went, its evaluations also where it fails. The caller
    /// refuses an increment that is not finite, and restarts what failed.
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]);
    /// The solution y of β̂(L(y)) = x of a trajectory's last step, `None` for a map without a bisection.
    fn solution(&self, at: usize) -> Option<&[f64]> {
        let _ = at;
        None
    }
    /// DΦ of a trajectory's last step, row-major; `None` where it is not offered.
    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        let _ = at;
        None
    }
    /// Operations of all so far, as [`SolverStatistics::operations`] counts them; `None` where they are
    /// not counted.
    fn operations(&self) -> Option<u64>;
    /// Forgets a trajectory's earlier steps.
    fn restart(&mut self, at: usize) {
        let _ = at;
    }
    /// Memory of a trajectory: the numbers that its later steps depend on beyond the state; always of the same
    /// length.
    fn memory(&self, at: usize) -> Vec<f64> {
        let _ = at;
        Vec::new()
    }
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, at: usize, memory: &[f64]) {
        let _ = (at, memory);
    }
}

/// How one trajectory's step went.
#[derive(Clone, Debug, PartialEq)]
pub struct StepReport {
    /// Its evaluations.
    pub evaluations: u64,
    /// Whether it counts as [`SolverStatistics::rounded`].
    pub is_rounded: bool,
    /// Part taken off this step so that a Casimir is held; [`SolverStatistics::held`] is the largest of all steps.
    pub held: f64,
    /// Why it could not be taken.
    pub outcome: Result<(), StepError>,
}

impl StepReport {
    /// Nothing yet.
    pub const NOTHING: Self = Self {
        evaluations: 0,
        is_rounded: false,
        held: 0.0,
        outcome: Ok(()),
    };

    /// Takes in a step of so many evaluations, or why it could not be taken.
    pub fn take(&mut self, step: Result<usize, StepError>, is_rounded: bool) {
        self.is_rounded = is_rounded;
        match step {
            Ok(evaluations) => self.evaluations += evaluations as u64,
            Err(error) => self.fail(error),
        }
    }

    /// Takes in a failure, unless an earlier one is known.
    pub fn fail(&mut self, error: StepError) {
        if self.outcome.is_ok() {
            self.outcome = Err(error);
        }
    }
}

/// A [`Stepper`] of trajectories, one a lane.
pub struct Lanes<T> {
    groups: Vec<Group<T>>,
    dimension: usize,
    lanes: usize,
    /// A group's x, low and increment, where there are several lanes.
    x: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    /// How it went; nothing between steps.
    taken: Vec<StepReport>,
    statistics: SolverStatistics,
}

/// Neighbouring lanes in lockstep.
struct Group<T> {
    trajectories: T,
    first: usize,
    count: usize,
}

impl<T: Trajectories> Lanes<T> {
    /// `lanes` trajectories in `dimension` coordinates, each by itself, made for its own parameters.
    pub fn apart(
        lanes: usize,
        dimension: usize,
        parameters: &[f64],
        mut make: impl FnMut(&[f64]) -> T,
    ) -> Self {
        Self::together(lanes, 1, dimension, parameters, |parameters, _| {
            make(parameters)
        })
    }

    /// `lanes` trajectories in `dimension` coordinates: neighbours with the same parameters, as many as
    /// `make` is told and at most `most`, in lockstep.
    pub fn together(
        lanes: usize,
        most: usize,
        dimension: usize,
        parameters: &[f64],
        mut make: impl FnMut(&[f64], usize) -> T,
    ) -> Self {
        let most = most.min(MOST_TOGETHER);
        let mut groups = Vec::new();
        let mut first = 0;
        while first < lanes {
            let own = of_lane(parameters, lanes, first);
            let count = (first + 1..lanes.min(first + most))
                .take_while(|lane| bits(&of_lane(parameters, lanes, *lane)).eq(bits(&own)))
                .count()
                + 1;
            groups.push(Group {
                trajectories: make(&own, count),
                first,
                count,
            });
            first += count;
        }
        let most = groups.iter().map(|group| group.count).max().unwrap_or(0);
        let room = || vec![0.0; if lanes > 1 { most * dimension } else { 0 }];
        Self {
            groups,
            dimension,
            lanes,
            x: room(),
            low: room(),
            increment: room(),
            taken: vec![StepReport::NOTHING; most],
            statistics: SolverStatistics::default(),
        }
    }
}

/// A lane's parameters.
fn of_lane(parameters: &[f64], lanes: usize, lane: usize) -> Vec<f64> {
    let own = parameters.iter().skip(lane).step_by(lanes);
    own.copied().collect()
}

fn bits(values: &[f64]) -> impl Iterator<Item = u64> {
    values.iter().map(|value| value.to_bits())
}

/// One step of a group, counted; zero where it fails.
fn step<T: Trajectories>(
    trajectories: &mut T,
    (x, low): (&[f64], &[f64]),
    increment: &mut [f64],
    taken: &mut [StepReport],
    statistics: &mut SolverStatistics,
) {
    trajectories.step(x, low, increment, taken);
    let d = increment.len() / taken.len();
    for (at, taken) in taken.iter_mut().enumerate() {
        let own = &mut increment[at * d..][..d];
        if !own.iter().all(|v| v.is_finite()) {
            taken.fail(StepError::OF_INCREMENT);
        }
        if taken.outcome.is_err() {
            trajectories.restart(at);
            own.fill(0.0);
        }
        let is_made = taken.outcome.is_ok();
        statistics.count(taken.evaluations, is_made);
        if is_made {
            statistics.rounded += u64::from(taken.is_rounded);
            statistics.held = statistics.held.max(taken.held);
        }
    }
}

impl<T: Trajectories> Stepper for Lanes<T> {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let (d, lanes, statistics) = (self.dimension, self.lanes, &mut self.statistics);
        let told = |taken: &mut StepReport| std::mem::replace(taken, StepReport::NOTHING).outcome;
        for group in &mut self.groups {
            let (first, count) = (group.first, group.count);
            let (group, taken) = (&mut group.trajectories, &mut self.taken[..count]);
            if lanes == 1 {
                step(group, (x, low), increment, taken, statistics);
                outcome[0] = told(&mut taken[0]);
                continue;
            }
            for (own, all) in [(&mut self.x, x), (&mut self.low, low)] {
                for j in 0..d {
                    for (at, value) in all[j * lanes + first..][..count].iter().enumerate() {
                        own[at * d + j] = *value;
                    }
                }
            }
            let start = (&self.x[..count * d], &self.low[..count * d]);
            let own = &mut self.increment[..count * d];
            step(group, start, own, taken, statistics);
            for j in 0..d {
                let row = &mut increment[j * lanes + first..][..count];
                for (at, place) in row.iter_mut().enumerate() {
                    *place = own[at * d + j];
                }
            }
            for (outcome, taken) in outcome[first..].iter_mut().zip(taken) {
                *outcome = told(taken);
            }
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        let group = self.groups.iter().find(|group| group.holds(lane))?;
        Some(group.trajectories.solution(lane - group.first)?.to_vec())
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let group = self.groups.iter_mut().find(|group| group.holds(lane))?;
        group.trajectories.tangent(lane - group.first)
    }

    fn restart(&mut self) {
        for group in &mut self.groups {
            (0..group.count).for_each(|at| group.trajectories.restart(at));
        }
    }

    fn statistics(&self) -> SolverStatistics {
        let groups = self.groups.iter();
        SolverStatistics {
            operations: groups.map(|group| group.trajectories.operations()).sum(),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        let of_group = |group: &Group<T>| -> Vec<f64> {
            let memory = |at| group.trajectories.memory(at);
            (0..group.count).flat_map(memory).collect()
        };
        self.groups.iter().flat_map(of_group).collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let expected = self.memory().len();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for group in &mut self.groups {
            for at in 0..group.count {
                let (own, others) = rest.split_at(group.trajectories.memory(at).len());
                group.trajectories.restore(at, own);
                rest = others;
            }
        }
        Ok(())
    }
}

impl<T> Group<T> {
    fn holds(&self, lane: usize) -> bool {
        (self.first..self.first + self.count).contains(&lane)
    }
}

impl<T: Trajectories + ?Sized> Trajectories for Box<T> {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        (**self).step(x, low, increment, taken);
    }

    fn solution(&self, at: usize) -> Option<&[f64]> {
        (**self).solution(at)
    }

    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        (**self).tangent(at)
    }

    fn operations(&self) -> Option<u64> {
        (**self).operations()
    }

    fn restart(&mut self, at: usize) {
        (**self).restart(at);
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        (**self).memory(at)
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        (**self).restore(at, memory);
    }
}
