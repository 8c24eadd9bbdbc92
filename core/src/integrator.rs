//! The compensated step loop.

use crate::error::StepError;
use crate::solver::{SolverStatistics, StepMap, Stepper};

/// The state x_k of one trajectory and the stepper that advances it.
///
/// The state is compensated: what rounding takes from x_k ← x_k + Δ is kept in a second double and
/// enters the next step, so that round-off grows like a random walk of steps' round-off, not of
/// states'.
pub struct Integrator {
    stepper: Box<dyn Stepper>,
    state: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    steps: u64,
    time_step: f64,
}

impl Integrator {
    /// Starts at `initial` with the given parameters and step sizes.
    ///
    /// # Panics
    /// When `initial` does not have the map's dimension.
    pub fn new(
        map: &dyn StepMap,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
        initial: &[f64],
    ) -> Self {
        assert_eq!(
            initial.len(),
            map.dimension(),
            "the initial state has the map's dimension"
        );
        Self {
            stepper: map.stepper(1, parameters, epsilon, h),
            state: initial.to_vec(),
            low: vec![0.0; initial.len()],
            increment: vec![0.0; initial.len()],
            steps: 0,
            time_step: epsilon * h,
        }
    }

    /// x_k.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// k.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// t = k ε h.
    pub fn time(&self) -> f64 {
        // Of no step backwards in time −0 is 0.
        self.steps as f64 * self.time_step + 0.0
    }

    /// The solver's work so far.
    pub fn statistics(&self) -> SolverStatistics {
        self.stepper.statistics()
    }

    /// Evaluations so far, those of [`statistics`](Self::statistics).
    pub fn evaluations(&self) -> u64 {
        self.stepper.evaluations()
    }

    /// x_k ↦ x_{k+1}.
    ///
    /// # Errors
    /// The solver's [`StepError`]; the state is then still x_k.
    pub fn step(&mut self) -> Result<(), StepError> {
        self.advance(1)
    }

    /// x_k ↦ x_{k+n}, to the same bits as n steps one by one. Steppers that are straight-line code stay in one loop.
    ///
    /// # Errors
    /// The [`StepError`] of the step that failed; the state is that before it, [`steps`](Self::steps) its number.
    pub fn advance(&mut self, steps: u64) -> Result<(), StepError> {
        let (state, low) = (&mut self.state, &mut self.low);
        let increment = &mut self.increment;
        let (made, outcome) = self.stepper.advance(steps, state, low, increment, None);
        self.steps += made;
        outcome
    }

    /// What the state holds beyond a double.
    pub fn compensation(&self) -> &[f64] {
        &self.low
    }

    /// Everything later steps depend on: x_k, its compensation and the solver's memory.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            steps: self.steps,
            state: self.state.clone(),
            compensation: self.low.clone(),
            memory: self.stepper.memory(),
        }
    }

    /// Continues from a checkpoint, to the same bits as without interruption.
    ///
    /// # Errors
    /// Returns the expected length when the checkpoint belongs to another method.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), usize> {
        if checkpoint.state.len() != self.state.len() {
            return Err(self.state.len());
        }
        self.stepper.restore(&checkpoint.memory)?;
        self.steps = checkpoint.steps;
        self.state.copy_from_slice(&checkpoint.state);
        self.low.copy_from_slice(&checkpoint.compensation);
        Ok(())
    }
}

/// The state of an [`Integrator`] between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// k.
    pub steps: u64,
    /// x_k.
    pub state: Vec<f64>,
    /// What x_k holds beyond a double.
    pub compensation: Vec<f64>,
    /// The solver's memory.
    pub memory: Vec<f64>,
}
