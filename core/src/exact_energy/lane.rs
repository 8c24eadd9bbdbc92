//! One trajectory's steps, each with the multiples that keep the energy.

use std::sync::Arc;

use crate::error::StepError;
use crate::solver::{Setting, SolverStatistics, StepMap, Stepper};
use crate::system::SystemInvariants;
use crate::two_sum;

/// Roundings of the energy that are taken for none: one of each coordinate, and one of H.
const ROUNDINGS: f64 = 1.0;

/// The same of the best step, where none is better.
pub(super) const MOST_ROUNDINGS: f64 = 16.0;

/// The first change of the multiples, over their units: the energy's size over the Casimir's.
pub(super) const FIRST_CHANGE: f64 = 1.0 / 1024.0;

/// The largest change of the multiples by a secant, over their units.
pub(super) const LARGEST_SECANT: f64 = 0.125;

/// One trajectory's multiples.
pub(super) struct LaneOfEnergy {
    pub stepper: Box<dyn Stepper>,
    pub map: Arc<dyn StepMap>,
    pub step_sizes: (f64, f64),
    /// Energy and Casimirs.
    pub invariants: SystemInvariants,
    /// The system's parameters, so many, and the multiples behind them.
    pub parameters: Vec<f64>,
    pub own: usize,
    /// H(x_0); not a number before the first step.
    pub target: f64,
    /// Room for the invariants and a state.
    pub values: Vec<f64>,
    pub state: Vec<f64>,
    /// Work of steppers that take no other parameters.
    pub spent: SolverStatistics,
    /// Whether a step of this search fell short of the energy, and whether one exceeded it.
    pub signs: [bool; 2],
}

/// Where a step begins.
#[derive(Clone, Copy)]
pub(super) struct Begin<'a> {
    pub x: &'a [f64],
    pub low: &'a [f64],
    pub memory: &'a [f64],
}

impl LaneOfEnergy {
    pub fn work(&self) -> SolverStatistics {
        self.spent.and(self.stepper.statistics())
    }

    pub fn multiples(&self) -> &[f64] {
        &self.parameters[self.own..]
    }

    /// The energy's error of the step with these multiples, which is left in `increment`.
    pub fn attempt(
        &mut self,
        multiples: &[f64],
        Begin { x, low, memory }: Begin<'_>,
        increment: &mut [f64],
    ) -> Result<f64, StepError> {
        self.parameters[self.own..].copy_from_slice(multiples);
        if !self.stepper.set(Setting::Parameters(&self.parameters)) {
            self.spent = self.work();
            let (epsilon, h) = self.step_sizes;
            self.stepper = self.map.stepper(1, &self.parameters, epsilon, h);
        }
        // Steps that are tried leave nothing behind.
        let restored = self.stepper.restore(memory);
        debug_assert!(restored.is_ok(), "it is of the same map");
        let mut outcome = [Ok(())];
        self.stepper.increment(x, low, increment, &mut outcome);
        let [outcome] = outcome;
        outcome?;
        let places = x.iter().zip(low).zip(&*increment);
        for (state, ((x, low), change)) in self.state.iter_mut().zip(places) {
            *state = two_sum(*x, change + low).0;
        }
        self.invariants.evaluate(&self.state, &mut self.values);
        let error = self.values[0] - self.target;
        self.signs[usize::from(error > 0.0)] |= error.is_finite();
        match error.is_finite() {
            true => Ok(error),
            false => Err(StepError::NonFinite { what: "the energy" }),
        }
    }

    /// |I| + Σ |x_i ∂_i I| of each invariant, by differences: u times it is what rounding the state changes.
    fn sizes(&mut self, x: &[f64]) -> Vec<f64> {
        /// A step of 2⁻²⁰ of a coordinate.
        const PART: f64 = 1.0 / (1 << 20) as f64;
        self.invariants.evaluate(x, &mut self.values);
        let here = self.values.clone();
        let mut sizes: Vec<f64> = here.iter().map(|value| value.abs()).collect();
        self.state.copy_from_slice(x);
        for i in 0..x.len() {
            self.state[i] = x[i] + PART * x[i];
            self.invariants.evaluate(&self.state, &mut self.values);
            for ((size, there), here) in sizes.iter_mut().zip(&self.values).zip(&here) {
                *size += (there - here).abs() / PART;
            }
            self.state[i] = x[i];
        }
        sizes
    }

    pub fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64]) -> Result<(), StepError> {
        let sizes = self.sizes(x);
        if self.target.is_nan() {
            self.invariants.evaluate(x, &mut self.values);
            self.target = self.values[0];
        }
        let units: Vec<f64> = (sizes[1..].iter())
            .map(|casimir| {
                if *casimir > 0.0 {
                    sizes[0] / casimir
                } else {
                    0.0
                }
            })
            .collect();
        let least = ROUNDINGS * 0.5 * f64::EPSILON * sizes[0];
        let before = self.multiples().to_vec();
        let memory = self.stepper.memory();
        let begin = Begin {
            x,
            low,
            memory: &memory,
        };
        let found = self.search((&units, least), begin, increment);
        if found.is_err() {
            self.parameters[self.own..].copy_from_slice(&before);
            let restored = self.stepper.restore(&memory);
            debug_assert!(restored.is_ok(), "it is of the same map");
        }
        found
    }

    pub fn restart(&mut self) {
        self.stepper.restart();
        self.parameters[self.own..].fill(0.0);
        self.target = f64::NAN;
    }

    pub fn memory(&self) -> Vec<f64> {
        let own = std::iter::once(&self.target);
        let own = own.chain(self.multiples());
        let mut memory: Vec<f64> = own.copied().collect();
        memory.extend(self.stepper.memory());
        memory
    }

    pub fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let count = self.parameters.len() - self.own;
        let (own, inner) = memory.split_at(1 + count);
        self.target = own[0];
        self.parameters[self.own..].copy_from_slice(&own[1..]);
        if !self.stepper.set(Setting::Parameters(&self.parameters)) {
            let (epsilon, h) = self.step_sizes;
            self.stepper = self.map.stepper(1, &self.parameters, epsilon, h);
        }
        self.stepper.restore(inner)
    }
}
