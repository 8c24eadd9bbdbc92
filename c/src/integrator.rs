//! One trajectory, step by step.

use leafwise::core::{Observer, Walk};

use leafwise_cli::failure::Failure;

use crate::call_error::CallError;
use crate::code::LeafwiseCode;
use crate::scene::Scene;

/// A trajectory of a scene at its present state.
pub(crate) struct Integrator {
    walk: Walk,
    coordinates: usize,
    /// The coordinate that is the time, where a pace makes steps of another.
    clock: Option<usize>,
    /// Energy and Casimirs.
    invariants: Observer,
    values: Vec<f64>,
}

impl Integrator {
    pub(crate) fn new(scene: &Scene) -> Result<Self, CallError> {
        let run = &scene.run;
        let acts = run.has_no_acts();
        acts.map_err(|acts| CallError {
            code: LeafwiseCode::LEAFWISE_UNSUPPORTED,
            message: acts.to_string(),
        })?;
        let invariants = run.invariants().map_err(Failure::from)?;
        Ok(Self {
            walk: run.walk(),
            coordinates: run.plan.layout.coordinates(),
            clock: run.time_place(),
            values: vec![0.0; 1 + run.system.casimir_names().len()],
            invariants,
        })
    }

    pub(crate) fn advance(&mut self, steps: u64) -> Result<(), CallError> {
        self.walk.advance(steps).map_err(|error| {
            let step = self.walk.steps() + 1;
            let mut refusal = CallError::from(error);
            refusal.message = format!("step {step} failed: {}", refusal.message);
            refusal
        })
    }

    pub(crate) fn state(&self) -> &[f64] {
        &self.walk.state()[..self.coordinates]
    }

    pub(crate) fn time(&self) -> f64 {
        match self.clock {
            Some(at) => self.walk.state()[at],
            None => self.walk.time(),
        }
    }

    pub(crate) fn steps(&self) -> u64 {
        self.walk.steps()
    }

    /// Energy and Casimirs at the present state.
    pub(crate) fn invariants(&mut self) -> &[f64] {
        (self.invariants).evaluate(self.walk.state(), &mut self.values);
        &self.values
    }
}
