//! Trajectories by their motions, which a short step would lose in the state.

use leafwise_core::{StepError, StepMap, Walk};
use leafwise_scene::compose::ComposedRun;
use nalgebra::DMatrix;

/// A trajectory from a state, by steps of the run's length in so many parts each.
pub(super) struct Motion {
    walk: Walk,
    parts: u64,
    start: Vec<f64>,
    /// x_k − x_0.
    pub increment: Vec<f64>,
}

impl Motion {
    pub fn new(run: &ComposedRun, map: &dyn StepMap, x: &[f64], parts: u32) -> Self {
        let (values, plan) = (run.system.parameter_values(), &run.plan);
        let h = plan.h / f64::from(parts);
        Self {
            walk: Walk::new(map, &values, plan.epsilon, h, x),
            parts: u64::from(parts),
            start: x.to_vec(),
            increment: vec![0.0; x.len()],
        }
    }

    /// One step of the run.
    pub fn advance(&mut self) -> Result<(), StepError> {
        self.walk.advance(self.parts)?;
        let states = self.walk.state().iter().zip(self.walk.compensation());
        let moved = states.zip(&self.start);
        for (place, ((x, low), start)) in self.increment.iter_mut().zip(moved) {
            *place = (x - start) + low;
        }
        Ok(())
    }

    /// ∂x_k/∂x_0 of the motion so far, by the same map; `None` where it offers none.
    pub fn tangent(&self, run: &ComposedRun, map: &dyn StepMap) -> Option<DMatrix<f64>> {
        let (values, plan) = (run.system.parameter_values(), &run.plan);
        let (h, d) = (plan.h / self.parts as f64, self.start.len());
        let mut walk = Walk::new(map, &values, plan.epsilon, h, &self.start);
        let mut tangent = DMatrix::identity(d, d);
        while walk.steps() < self.walk.steps() {
            walk.advance(1).ok()?;
            tangent = DMatrix::from_row_slice(d, d, &walk.tangent(0)?) * tangent;
        }
        Some(tangent)
    }
}

/// The motion from x over one step.
pub(super) fn increment(
    run: &ComposedRun,
    map: &dyn StepMap,
    x: &[f64],
) -> Result<Vec<f64>, StepError> {
    let mut motion = Motion::new(run, map, x, 1);
    motion.advance()?;
    Ok(motion.increment)
}
