//! Trajectories by their increments, which a short step would lose in the state.

use leafwise_core::{StepError, StepMap, Stepper};

use leafwise_scene::compose::ComposedRun;

/// A trajectory from a state, by steps of the run's length in so many parts each.
pub(super) struct Walk {
    stepper: Box<dyn Stepper>,
    parts: u32,
    state: Vec<f64>,
    /// The motion so far.
    pub increment: Vec<f64>,
}

impl Walk {
    pub fn new(run: &ComposedRun, map: &dyn StepMap, x: &[f64], parts: u32) -> Self {
        let (values, plan) = (run.system.parameter_values(), &run.plan);
        Self {
            stepper: map.stepper(1, &values, plan.epsilon, plan.h / f64::from(parts)),
            parts,
            state: x.to_vec(),
            increment: vec![0.0; x.len()],
        }
    }

    /// One step of the run.
    pub fn advance(&mut self) -> Result<(), StepError> {
        let low = vec![0.0; self.state.len()];
        for _ in 0..self.parts {
            let mut increment = vec![0.0; self.state.len()];
            let mut outcome = [Ok(())];
            self.stepper
                .increment(&self.state, &low, &mut increment, &mut outcome);
            let [outcome] = outcome;
            outcome?;
            for (at, part) in increment.iter().enumerate() {
                self.state[at] += part;
                self.increment[at] += part;
            }
            if self.state.iter().any(|x| !x.is_finite()) {
                return Err(StepError::NonFinite {
                    what: "the new state",
                });
            }
        }
        Ok(())
    }
}

/// The motion from x over one step.
pub(super) fn increment(
    run: &ComposedRun,
    map: &dyn StepMap,
    x: &[f64],
) -> Result<Vec<f64>, StepError> {
    let mut walk = Walk::new(run, map, x, 1);
    walk.advance()?;
    Ok(walk.increment)
}
