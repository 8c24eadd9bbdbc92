//! What the implicit Runge–Kutta methods share.

use std::sync::Arc;

use leafwise_core::runge_kutta::{SmoothMap, StageSolver, Tableau};
use leafwise_core::{BuildError, MapProperties, PoissonSystem, StepError, StepMap, Structure};
use nalgebra::DMatrix;

use crate::one_step::{OneStep, ReferenceMap};

/// An implicit Runge–Kutta method for one trajectory.
pub(crate) struct ImplicitRungeKutta(StageSolver);

impl ImplicitRungeKutta {
    pub(crate) fn new(
        field: &SmoothMap,
        tableau: Tableau,
        parameters: &[f64],
        time_step: f64,
    ) -> Self {
        let field = field.evaluator(parameters, 1.0, 1.0);
        Self(StageSolver::new(field, tableau, time_step))
    }
}

impl OneStep for ImplicitRungeKutta {
    fn increment(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        self.0.solve(x, increment)
    }

    fn operations(&self) -> Option<u64> {
        self.0.operations()
    }

    fn tangent(&mut self) -> Option<DMatrix<f64>> {
        let d = self.0.dimension();
        self.0.tangent(&DMatrix::identity(d, d))
    }

    fn restart(&mut self) {
        self.0.clear();
    }

    fn memory(&self) -> Vec<f64> {
        self.0.memory()
    }

    fn restore(&mut self, memory: &[f64]) {
        self.0.restore(memory);
    }
}

/// The Gauss method with this tableau: symplectic, so a Poisson map where the tensor is constant
/// (Hairer, Lubich, Wanner, *Geometric Numerical Integration*, theorem VI.4.3).
pub(crate) fn gauss_map(
    system: &PoissonSystem,
    tableau: Tableau,
    description: String,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let field = system.field_map()?;
    let constant = system
        .expressions()
        .is_some_and(|system| system.tensor().values().all(|e| e.variables().is_empty()));
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: MapProperties {
            order: 2 * tableau.stages(),
            structure: if constant {
                Structure::Exact
            } else {
                Structure::None
            },
            self_adjoint: Some(true),
        },
        description,
        make: Box::new(move |parameters, time_step| {
            let tableau = tableau.clone();
            Box::new(ImplicitRungeKutta::new(
                &field, tableau, parameters, time_step,
            ))
        }),
    }))
}
