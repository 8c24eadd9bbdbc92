//! Realization and dynamic approximation combined into a step map.

use std::sync::Arc;

use leafwise_expression::{Graph, StepSize, Term};

use crate::dynamics::{DynamicApproximation, LagrangianBisection};
use crate::error::BuildError;
use crate::realization::{Accuracy, RealizationData};
use crate::solver::{NewtonKernel, StepMap, Stepper};
use crate::system::PoissonSystem;

/// φ̂_{ε,h} = α̂_ε ∘ (β̂_ε|_L)⁻¹ (paper, Definition 2.4 and Algorithm 1): given x_k, find y with
/// β̂(L(y)) = x_k and return x_{k+1} = x_k + (α̂ − β̂)(L(y)).
#[derive(Clone, Debug)]
pub struct Method {
    realization: Arc<dyn RealizationData>,
    dynamics: Arc<dyn DynamicApproximation>,
    bisection: Arc<dyn LagrangianBisection>,
    newton: NewtonKernel,
}

impl Method {
    /// Combines the two approximations for a system and compiles what its steps need.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization lacks what the bisection needs,
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn compose(
        system: &PoissonSystem,
        realization: Arc<dyn RealizationData>,
        dynamics: Arc<dyn DynamicApproximation>,
    ) -> Result<Self, BuildError> {
        let bisection = dynamics.bisection(system, realization.as_ref())?;
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: dynamics.describe(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        let ends = realization
            .code()
            .ok_or_else(|| missing("it offers no code for its maps"))?;
        let points = bisection
            .code()
            .ok_or_else(|| missing("the bisection offers no code"))?;
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let h = graph.step_size(StepSize::H);
        let z = points.point(&mut graph, &epsilon, &h, &y)?;
        let ends = ends.source_and_target(&mut graph, &epsilon, &z)?;
        let newton = NewtonKernel::compile(&mut graph, &ends, system.parameters().len())?;
        Ok(Self {
            realization,
            dynamics,
            bisection,
            newton,
        })
    }

    /// The geometric approximation R̂_ε.
    pub fn realization(&self) -> &dyn RealizationData {
        self.realization.as_ref()
    }

    /// The dynamic approximation.
    pub fn dynamics(&self) -> &dyn DynamicApproximation {
        self.dynamics.as_ref()
    }

    /// The Lagrangian bisection of this system.
    pub fn bisection(&self) -> &dyn LagrangianBisection {
        self.bisection.as_ref()
    }

    /// The compiled Newton iteration.
    pub fn newton(&self) -> &NewtonKernel {
        &self.newton
    }

    /// Theorem 2's bound min(n, m) on the order in t = εh; m alone over an exact realization.
    pub fn declared_order(&self) -> usize {
        let m = self.dynamics.order();
        match self.realization.accuracy() {
            Accuracy::Exact => m,
            Accuracy::Order(n) => n.min(m),
        }
    }
}

impl StepMap for Method {
    fn dimension(&self) -> usize {
        self.realization.dimension()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.newton.stepper(lanes, parameters, epsilon, h)
    }
}
