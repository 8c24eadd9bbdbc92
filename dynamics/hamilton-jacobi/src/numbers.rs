//! graph(h dH) for systems of numbers.

use std::sync::Arc;

use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::{
    BuildError, ChartMaps, Evaluator, GraphOfOneForm, LagrangianBisection, PoissonSystem,
    RealizationData, StepError,
};

/// y ↦ χ(y, h dH(y)): S = h H, the generating function of order 2, is the same in every chart and
/// needs ∇H alone.
#[derive(Clone, Debug)]
pub struct GraphOfEnergy {
    gradient: SmoothMap,
    chart: ChartMaps,
    dimension: usize,
    space: usize,
}

impl GraphOfEnergy {
    /// The bisection over a realization. Messages call the approximation `dynamics`.
    ///
    /// # Errors
    /// Fails with [`BuildError::Incompatible`] when the realization has no chart about its section.
    /// Fails with it, too, when β̂(x, p) is not α̂(x, −p) in that chart.
    pub fn new(
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
        dynamics: &str,
    ) -> Result<Self, BuildError> {
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: dynamics.to_owned(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        if !realization.is_reversible() {
            return Err(missing(
                "beta(x, p) is not alpha(x, -p) there, so that even coefficients of S do not vanish",
            ));
        }
        let chart = ChartMaps::of(realization, system.parameters().len())?
            .ok_or_else(|| missing("it has no symplectic chart about its section"))?;
        Ok(Self {
            gradient: system.gradient_map()?,
            chart,
            dimension: realization.dimension(),
            space: realization.space_dimension(),
        })
    }

    fn form(&self, parameters: &[f64], h: f64) -> Box<dyn Evaluator> {
        Box::new(EnergyForm {
            gradient: self.gradient.evaluator(parameters, 1.0, h),
            h,
        })
    }
}

impl LagrangianBisection for GraphOfEnergy {
    fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        Some(Box::new(GraphOfOneForm::new(
            self.form(parameters, h),
            self.chart.evaluator(parameters, epsilon),
            self.dimension,
            self.space,
        )))
    }

    fn one_form(&self, parameters: &[f64], _epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        Some(self.form(parameters, h))
    }
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

    fn has_jacobian(&self) -> bool {
        self.gradient.has_jacobian()
    }

    fn operations(&self) -> Option<u64> {
        self.gradient.operations()
    }
}
