//! h dH for systems of numbers.

use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::{BuildError, Evaluator, PoissonSystem, StepError};

/// y ↦ h dH(y): S = h H, the generating function of order 2, is the same in every chart and needs ∇H alone.
///
/// # Errors
/// Those of [`PoissonSystem::gradient_map`].
pub fn differential(system: &PoissonSystem) -> Result<SmoothMap, BuildError> {
    let (gradient, d) = (system.gradient_map()?, system.dimension());
    let has_jacobian = gradient.has_jacobian();
    let form = move |parameters: &[f64], _: f64, h: f64| -> Box<dyn Evaluator> {
        let gradient = gradient.evaluator(parameters, 1.0, h);
        Box::new(EnergyForm { gradient, h })
    };
    Ok(SmoothMap::from_numbers(d, d, has_jacobian, form))
}

/// θ = h dH.
struct EnergyForm {
    gradient: SmoothMapEvaluator,
    h: f64,
}

impl EnergyForm {
    fn scale(&self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| *value *= self.h);
    }
}

impl Evaluator for EnergyForm {
    fn values(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        self.gradient.values(y, p)?;
        self.scale(p);
        Ok(())
    }

    fn jacobians(&mut self, y: &[f64], jacobians: &mut [f64]) -> Result<(), StepError> {
        self.gradient.jacobians(y, jacobians)?;
        self.scale(jacobians);
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        self.gradient.operations()
    }
}
