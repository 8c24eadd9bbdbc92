//! Implicit Runge–Kutta methods: the evaluator that they share, and the Gauss methods as step maps.

use std::sync::Arc;

use leafwise_core::runge_kutta::{SmoothMap, StageSolver, Tableau};
use leafwise_core::solver::{StepReport, Trajectories, check_equations};
use leafwise_core::{BuildError, MapProperties, MotionClass, PoissonSystem, StepMap, Structure};
use nalgebra::DMatrix;

use crate::reference_map::{ReferenceMap, row_major};

/// An implicit Runge–Kutta method for several trajectories.
pub(crate) struct ImplicitRungeKutta(StageSolver);

impl ImplicitRungeKutta {
    pub(crate) fn new(
        field: &SmoothMap,
        tableau: Tableau,
        parameters: &[f64],
        time_step: f64,
        count: usize,
    ) -> Self {
        let field = field.evaluator(parameters, 1.0, 1.0);
        Self(StageSolver::new(field, tableau, time_step, count).by_lanes())
    }
}

impl Trajectories for ImplicitRungeKutta {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        self.0.solve_all(x, increment, taken);
    }

    fn operations(&self) -> Option<u64> {
        self.0.operations()
    }

    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        let d = self.0.dimension();
        Some(row_major(&self.0.tangent(at, &DMatrix::identity(d, d))?))
    }

    fn restart(&mut self, at: usize) {
        self.0.clear(at);
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        self.0.memory(at)
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        self.0.restore(at, memory);
    }
}

/// The Gauss method with this tableau: symplectic, so a Poisson map where the tensor is constant (Hairer, Lubich,
/// Wanner, *Geometric Numerical Integration*, theorem VI.4.3). The map is Poisson, too, where the tensor depends only
/// on coordinates that rest.
///
/// If Π has no entry in the row of x_k, x_k is a Casimir, and every stage has the x_k of the state. Where Π depends on
/// such coordinates alone it is constant on each of their level sets. The step there is that of a constant tensor.
/// Derivatives in DΦ Π DΦᵀ are taken along the level set alone, for Π has no others.
pub(crate) fn gauss_map(
    system: &PoissonSystem,
    tableau: Tableau,
    description: String,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let opaque = system.opaque();
    if opaque.is_none_or(|system| system.numbers.derivatives.of_field()) {
        check_equations(tableau.stages() * system.dimension())?;
    }
    let field = system.field_map()?;
    let is_kept = system.expressions().is_some_and(|system| {
        let tensor = system.tensor();
        let moves = |k: &usize| tensor.keys().any(|(i, j)| i == k || j == k);
        let mut entries = tensor.values();
        entries.all(|entry| !entry.variables().iter().any(moves))
    });
    let is_kept = is_kept || opaque.is_some_and(|system| system.numbers.has_resting_tensor());
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: MapProperties {
            order: 2 * tableau.stages(),
            structure: match (is_kept, system.motion()) {
                (true, MotionClass::Hamiltonian) => Structure::Exact,
                // Slopes are in the image of a constant tensor.
                (true, MotionClass::OnLeaves) => Structure::Leaves,
                (true, MotionClass::OffLeaves) | (false, _) => Structure::None,
            },
            self_adjoint: Some(true),
        },
        description,
        together: usize::MAX,
        kept_signs: Vec::new(),
        make: Box::new(move |parameters, time_step, count| {
            let tableau = tableau.clone();
            Box::new(ImplicitRungeKutta::new(
                &field, tableau, parameters, time_step, count,
            ))
        }),
    }))
}
