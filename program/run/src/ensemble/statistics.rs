//! Reductions of an ensemble, member after member.

use leafwise_core::SolverStatistics;
use leafwise_scene::json::{double, doubles};
use serde::{Deserialize, Serialize};

use super::quantiles::{Quantile, Sketch};
use crate::StatisticsFields;

/// The most failed members that are reported one by one.
pub(super) const MOST_NAMED: usize = 1000;

/// One observable at one time, over the members.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Members with a finite value.
    pub count: u64,
    /// Members whose value is not finite; they enter nothing else.
    pub undefined: u64,
    /// Their mean.
    pub mean: f64,
    /// Σ (value − mean)².
    pub(super) squares: f64,
    /// The smallest value, and the first member that has it.
    pub minimum: (f64, u64),
    /// The largest value, and the first member that has it.
    pub maximum: (f64, u64),
    /// For quantiles, where some are asked for.
    pub(super) sketch: Option<Sketch>,
}

impl Summary {
    pub(super) fn new(has_quantiles: bool) -> Self {
        Self {
            count: 0,
            undefined: 0,
            mean: 0.0,
            squares: 0.0,
            minimum: (f64::INFINITY, 0),
            maximum: (f64::NEG_INFINITY, 0),
            sketch: has_quantiles.then(Sketch::default),
        }
    }

    /// Takes in a member's value, by Welford's recurrence.
    pub(super) fn push(&mut self, value: f64, member: u64) {
        if !value.is_finite() {
            self.undefined += 1;
            return;
        }
        self.count += 1;
        let change = value - self.mean;
        self.mean += change / self.count as f64;
        self.squares += change * (value - self.mean);
        if value < self.minimum.0 {
            self.minimum = (value, member);
        }
        if value > self.maximum.0 {
            self.maximum = (value, member);
        }
        if let Some(sketch) = &mut self.sketch {
            sketch.push(value);
        }
    }

    /// Takes in the members behind those here, by the formula of T. F. Chan, G. H. Golub and R. J. LeVeque (1983).
    pub(super) fn join(&mut self, later: Self) {
        self.undefined += later.undefined;
        if later.count > 0 {
            let (before, more) = (self.count as f64, later.count as f64);
            let all = before + more;
            let change = later.mean - self.mean;
            self.count += later.count;
            self.mean += change * (more / all);
            self.squares += later.squares + change * change * (before * more / all);
        }
        // Of equal values the first member's stays.
        if later.minimum.0 < self.minimum.0 {
            self.minimum = later.minimum;
        }
        if later.maximum.0 > self.maximum.0 {
            self.maximum = later.maximum;
        }
        if let (Some(own), Some(more)) = (&mut self.sketch, later.sketch) {
            own.join(more);
        }
    }

    /// The unbiased variance; 0 for fewer than two members.
    pub fn variance(&self) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        self.squares / (self.count - 1) as f64
    }

    /// The square root of the variance.
    pub fn deviation(&self) -> f64 {
        libm::sqrt(self.variance())
    }

    /// The standard error of the mean, √(variance/count).
    pub fn standard_error(&self) -> f64 {
        libm::sqrt(self.variance() / self.count.max(1) as f64)
    }

    /// Half the length of the 95 % confidence interval about the mean, 1.96 standard errors.
    pub fn confidence(&self) -> f64 {
        1.96 * self.standard_error()
    }

    /// The quantiles of these parts of the members, nothing where none were asked for.
    pub fn quantiles(&self, parts: &[f64]) -> Vec<Quantile> {
        let sketch = self.sketch.as_ref();
        sketch.map_or_else(Vec::new, |sketch| sketch.quantiles(parts))
    }
}

/// An invariant's deviations |I(x_k) − I(x_0)| in one window of steps, over the members.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// The largest.
    pub maximum: f64,
    /// The first member that has it.
    pub member: u64,
    /// The sum of the members' largest.
    pub(super) sum: f64,
    /// How many members that are.
    pub(super) count: u64,
}

impl Deviation {
    pub(super) fn new() -> Self {
        Self {
            maximum: 0.0,
            member: 0,
            sum: 0.0,
            count: 0,
        }
    }

    pub(super) fn push(&mut self, deviation: f64, member: u64) {
        if deviation > self.maximum {
            (self.maximum, self.member) = (deviation, member);
        }
        self.sum += deviation;
        self.count += 1;
    }

    /// Takes in the members behind those here.
    fn join(&mut self, later: Self) {
        if later.maximum > self.maximum {
            (self.maximum, self.member) = (later.maximum, later.member);
        }
        self.sum += later.sum;
        self.count += later.count;
    }

    /// The mean of the members' largest.
    pub fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }
}

/// A member that did not reach the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MemberFailure {
    /// Which one.
    pub member: u64,
    /// The step that failed, counted from 1; 0 where there is no initial state.
    pub step: u64,
    /// The time before that step.
    #[serde(serialize_with = "double")]
    pub time: f64,
    /// Message on what happened.
    pub message: String,
    /// The last good state.
    #[serde(serialize_with = "doubles")]
    pub state: Vec<f64>,
}

/// Everything an ensemble is reduced to. Members that fail are counted, and enter nothing else; those that the scene's
/// condition ends enter what lies before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reductions {
    /// Members that were taken in, in their order.
    pub members: u64,
    /// How many of them failed.
    pub failed: u64,
    /// The first thousand of these.
    pub failures: Vec<MemberFailure>,
    /// Members that the scene's condition has ended.
    pub stopped: u64,
    /// Those of them in each window of steps, behind those at the beginning; nothing without a condition.
    pub(super) losses: Vec<u64>,
    /// Observables at one time after those at the time before.
    pub summaries: Vec<Summary>,
    /// Invariants in one window after those in the window before.
    pub windows: Vec<Deviation>,
    /// Invariants over the whole run.
    pub whole: Vec<Deviation>,
    /// The same relative to |I(x_0)|, members with I(x_0) = 0 left out.
    pub relative: Vec<Deviation>,
    /// I(x_0) over the members.
    pub initial: Vec<Summary>,
    /// The solver's work, failed members included.
    #[serde(with = "StatisticsFields")]
    pub statistics: SolverStatistics,
}

/// The sizes of [`Reductions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Shape {
    pub times: usize,
    pub observables: usize,
    pub windows: usize,
    pub invariants: usize,
    pub has_quantiles: bool,
    /// Times at which members that have ended are counted.
    pub losses: usize,
}

impl Reductions {
    pub(super) fn new(shape: Shape) -> Self {
        let deviations = |count: usize| vec![Deviation::new(); count];
        Self {
            members: 0,
            failed: 0,
            failures: Vec::new(),
            stopped: 0,
            losses: vec![0; shape.losses],
            summaries: vec![Summary::new(shape.has_quantiles); shape.times * shape.observables],
            windows: deviations(shape.windows * shape.invariants),
            whole: deviations(shape.invariants),
            relative: deviations(shape.invariants),
            initial: vec![Summary::new(false); shape.invariants],
            statistics: SolverStatistics::default(),
        }
    }

    /// Members that reached the end.
    pub fn done(&self) -> u64 {
        self.members - self.failed - self.stopped
    }

    pub(super) fn add_work(&mut self, work: SolverStatistics) {
        self.statistics = self.statistics.and(work);
    }

    /// Takes in the members behind those here.
    pub(super) fn join(&mut self, later: Self) {
        self.members += later.members;
        self.failed += later.failed;
        let room = MOST_NAMED - self.failures.len();
        self.failures.extend(later.failures.into_iter().take(room));
        self.stopped += later.stopped;
        for (own, more) in self.losses.iter_mut().zip(later.losses) {
            *own += more;
        }
        let summaries = [
            (&mut self.summaries, later.summaries),
            (&mut self.initial, later.initial),
        ];
        for (own, more) in summaries {
            own.iter_mut()
                .zip(more)
                .for_each(|(own, more)| own.join(more));
        }
        let deviations = [
            (&mut self.windows, later.windows),
            (&mut self.whole, later.whole),
            (&mut self.relative, later.relative),
        ];
        for (own, more) in deviations {
            own.iter_mut()
                .zip(more)
                .for_each(|(own, more)| own.join(more));
        }
        self.add_work(later.statistics);
    }

    pub(super) fn push_failure(&mut self, failure: MemberFailure) {
        self.failed += 1;
        if self.failures.len() < MOST_NAMED {
            self.failures.push(failure);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_two_passes() {
        let values: Vec<f64> = (0..1000).map(|k| 1e6 + libm::sin(k as f64)).collect();
        let mut summary = Summary::new(false);
        for (member, value) in values.iter().enumerate() {
            summary.push(*value, member as u64);
        }
        summary.push(f64::NAN, 1000);
        let n = values.len() as f64;
        let mean = values.iter().map(|v| v - 1e6).sum::<f64>() / n;
        let squares: f64 = values
            .iter()
            .map(|v| (v - 1e6 - mean) * (v - 1e6 - mean))
            .sum();
        assert_eq!((summary.count, summary.undefined), (1000, 1));
        // Each value is rounded to 1.2e-10; a thousand additions to the mean round as much.
        assert!((summary.mean - 1e6 - mean).abs() < 1e3 * 1.2e-10);
        assert!((summary.variance() / (squares / (n - 1.0)) - 1.0).abs() < 1e-9);
        let largest = values.iter().copied().fold(f64::MIN, f64::max);
        assert_eq!(summary.maximum.0, largest);
        assert_eq!(values[summary.minimum.1 as usize], summary.minimum.0);
    }
}
