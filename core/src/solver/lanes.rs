//! Trajectories one after the other: what steppers that do not step them together share.

use super::{SolverStatistics, Stepper};
use crate::error::StepError;

/// The step of one trajectory, for fixed parameters and step sizes: a stepper's mathematics.
pub trait Trajectory: Send {
    /// Φ(x + low) − (x + low), where `low` carries what the compensated state holds beyond a double.
    /// Adds its evaluations to `evaluations`, also where it fails. An increment that is not finite is
    /// refused by the caller.
    ///
    /// # Errors
    /// Why the step could not be taken; the trajectory is then restarted.
    fn step(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError>;
    /// The solution y of β̂(L(y)) = x of the last step, `None` for a map without a bisection.
    fn solution(&self) -> Option<&[f64]> {
        None
    }
    /// DΦ of the last step, row-major; `None` where it is not offered.
    fn tangent(&mut self) -> Option<Vec<f64>> {
        None
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for one that does
    /// not count.
    fn operations(&self) -> Option<u64>;
    /// Forgets earlier steps.
    fn restart(&mut self) {}
    /// What later steps depend on beyond the state; always of the same length.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, memory: &[f64]) {
        let _ = memory;
    }
}

/// A [`Stepper`] of trajectories, one a lane.
pub struct LaneByLane<T> {
    trajectories: Vec<T>,
    /// One lane's x, low and increment, where there are several.
    x: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    statistics: SolverStatistics,
}

impl<T: Trajectory> LaneByLane<T> {
    /// `lanes` trajectories in `dimension` coordinates, each made for its own parameters.
    pub fn new(
        lanes: usize,
        dimension: usize,
        parameters: &[f64],
        mut make: impl FnMut(&[f64]) -> T,
    ) -> Self {
        let room = || vec![0.0; if lanes > 1 { dimension } else { 0 }];
        let of = |lane: usize| -> Vec<f64> {
            parameters
                .iter()
                .skip(lane)
                .step_by(lanes)
                .copied()
                .collect()
        };
        Self {
            trajectories: (0..lanes).map(|lane| make(&of(lane))).collect(),
            x: room(),
            low: room(),
            increment: room(),
            statistics: SolverStatistics::default(),
        }
    }
}

/// One step of one trajectory, counted; zero where it fails.
fn step<T: Trajectory>(
    trajectory: &mut T,
    (x, low): (&[f64], &[f64]),
    increment: &mut [f64],
    statistics: &mut SolverStatistics,
) -> Result<(), StepError> {
    let mut evaluations = 0;
    let outcome = trajectory.step(x, low, increment, &mut evaluations);
    let outcome = outcome.and_then(|()| {
        if increment.iter().all(|v| v.is_finite()) {
            return Ok(());
        }
        Err(StepError::NonFinite {
            what: "the increment",
        })
    });
    if outcome.is_err() {
        trajectory.restart();
        increment.fill(0.0);
    }
    statistics.count(evaluations, outcome.is_ok());
    outcome
}

impl<T: Trajectory> Stepper for LaneByLane<T> {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let statistics = &mut self.statistics;
        if let [trajectory] = &mut self.trajectories[..] {
            outcome[0] = step(trajectory, (x, low), increment, statistics);
            return;
        }
        let lanes = self.trajectories.len();
        for (lane, trajectory) in self.trajectories.iter_mut().enumerate() {
            for (own, all) in [(&mut self.x, x), (&mut self.low, low)] {
                let column = all.iter().skip(lane).step_by(lanes);
                own.iter_mut()
                    .zip(column)
                    .for_each(|(own, value)| *own = *value);
            }
            let start = (&self.x[..], &self.low[..]);
            outcome[lane] = step(trajectory, start, &mut self.increment, statistics);
            let places = increment.iter_mut().skip(lane).step_by(lanes);
            places
                .zip(&self.increment)
                .for_each(|(place, value)| *place = *value);
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        Some(self.trajectories.get(lane)?.solution()?.to_vec())
    }

    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        self.trajectories.get_mut(lane)?.tangent()
    }

    fn restart(&mut self) {
        self.trajectories.iter_mut().for_each(Trajectory::restart);
    }

    fn statistics(&self) -> SolverStatistics {
        SolverStatistics {
            operations: self.trajectories.iter().map(Trajectory::operations).sum(),
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        self.trajectories
            .iter()
            .flat_map(Trajectory::memory)
            .collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let lengths = self.trajectories.iter().map(|t| t.memory().len());
        let lengths: Vec<usize> = lengths.collect();
        let expected = lengths.iter().sum();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for (trajectory, length) in self.trajectories.iter_mut().zip(lengths) {
            let (own, others) = rest.split_at(length);
            trajectory.restore(own);
            rest = others;
        }
        Ok(())
    }
}

impl<T: Trajectory + ?Sized> Trajectory for Box<T> {
    fn step(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        (**self).step(x, low, increment, evaluations)
    }

    fn solution(&self) -> Option<&[f64]> {
        (**self).solution()
    }

    fn tangent(&mut self) -> Option<Vec<f64>> {
        (**self).tangent()
    }

    fn operations(&self) -> Option<u64> {
        (**self).operations()
    }

    fn restart(&mut self) {
        (**self).restart();
    }

    fn memory(&self) -> Vec<f64> {
        (**self).memory()
    }

    fn restore(&mut self, memory: &[f64]) {
        (**self).restore(memory);
    }
}
