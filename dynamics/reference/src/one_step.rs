//! A method as a step map: its trajectories each by themselves, or several in lockstep.

use leafwise_core::solver::{Lanes, Lockstep, Trajectory};
use leafwise_core::{MapProperties, StepError, StepMap, Stepper};
use nalgebra::DMatrix;

/// One thread's evaluator of a method, for fixed parameters and time step.
pub(crate) trait OneStep: Send {
    /// Φ(x) − x; returns how often the field was evaluated at all stages.
    fn increment(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError>;
    /// Operations so far, as [`Trajectory::operations`] counts them; `None` over a system that
    /// does not count.
    fn operations(&self) -> Option<u64>;
    /// As [`Trajectory::is_rounded`].
    fn is_rounded(&self) -> bool {
        false
    }
    /// DΦ at the x of the last step, `None` where it is not offered.
    fn tangent(&mut self) -> Option<DMatrix<f64>> {
        None
    }
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

type MakeOne = dyn Fn(&[f64], f64) -> Box<dyn OneStep> + Send + Sync;
type MakeSeveral = dyn Fn(&[f64], f64, usize) -> Box<dyn Lockstep> + Send + Sync;

/// What makes a method's evaluators, for parameters and a time step.
pub(crate) enum Make {
    /// That of one trajectory.
    Apart(Box<MakeOne>),
    /// That of so many trajectories. It steps from the doubles `x`, as [`Lane`] does.
    Together(Box<MakeSeveral>),
}

/// A method as a [`StepMap`].
pub(crate) struct ReferenceMap {
    pub(crate) dimension: usize,
    pub(crate) properties: MapProperties,
    pub(crate) description: String,
    pub(crate) make: Make,
}

impl StepMap for ReferenceMap {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let (d, time_step) = (self.dimension, epsilon * h);
        match &self.make {
            Make::Apart(make) => {
                let make = |parameters: &[f64]| Lane(make(parameters, time_step));
                Box::new(Lanes::apart(lanes, d, parameters, make))
            }
            Make::Together(make) => {
                let make = |parameters: &[f64], count| make(parameters, time_step, count);
                Box::new(Lanes::together(lanes, usize::MAX, d, parameters, make))
            }
        }
    }
}

/// A method as the [`Trajectory`] of a lane.
struct Lane(Box<dyn OneStep>);

impl Trajectory for Lane {
    /// Steps from the double `x`: what the compensated state holds beyond it, half a unit in the last
    /// place, changes an increment by less than its own rounding.
    fn step(
        &mut self,
        x: &[f64],
        _low: &[f64],
        increment: &mut [f64],
        evaluations: &mut u64,
    ) -> Result<(), StepError> {
        *evaluations += self.0.increment(x, increment)? as u64;
        Ok(())
    }

    fn is_rounded(&self) -> bool {
        self.0.is_rounded()
    }

    fn tangent(&mut self) -> Option<Vec<f64>> {
        Some(row_major(&self.0.tangent()?))
    }

    fn operations(&self) -> Option<u64> {
        self.0.operations()
    }

    fn restart(&mut self) {
        self.0.restart();
    }

    fn memory(&self) -> Vec<f64> {
        self.0.memory()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.0.restore(memory);
    }
}

/// The entries of a matrix, row by row.
pub(crate) fn row_major(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}
