//! The dynamic approximation.

use std::sync::Arc;

pub use leafwise_solver::Correction;

use crate::bisection::LagrangianBisection;
use crate::error::BuildError;
pub use crate::generating_function::{Generating, GeneratingCode, GeneratingFunction};
use crate::realization::RealizationData;
use crate::system::{MotionClass, PoissonSystem};

/// Provides a Lagrangian bisection L̂_{ε,h} ↪ (S, ω) that approximates
/// L_{ε,h} = φ_h^{α_ε^*H}(σ(M)) to order m in h (paper, section 4.1).
pub trait DynamicApproximation: Send + Sync + std::fmt::Debug {
    /// Order and structure of its map, and the systems and realizations that it takes.
    fn properties(&self) -> DynamicsProperties;
    /// One line for reports: name and order.
    fn describe(&self) -> String;
    /// The bisection for this system and realization.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization lacks what this approximation needs.
    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError>;
}

/// Properties of a [`DynamicApproximation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicsProperties {
    /// m.
    pub order: usize,
    /// Whether the induced map is self-adjoint over a realization with β̂(x, p) = α̂(x, −p); `None` where that is not
    /// known.
    pub self_adjoint: Option<bool>,
    /// Whether L is Lagrangian to round-off: only then is the induced map declared Poisson. Of another L it maps along leaves.
    pub is_lagrangian: bool,
    /// The motions that it approximates: methods refuse others.
    pub takes: MotionClass,
    /// Whether it steps in the coordinates of a [`Lift`](crate::Lift): others need α̂ and β̂.
    pub serves_lifts: bool,
    /// Whether y ↦ L(y) is solved for β̂(L(y)) = x, or taken at y = x.
    pub correction: Correction,
    /// The length |εh| of the only steps that its map holds for; `None` where all are made.
    pub time_step: Option<f64>,
}

impl DynamicsProperties {
    /// Those of a Lagrangian bisection of order m that is solved for, of steps of any length, of systems without forces over maps α̂ and β̂.
    pub fn of_order(order: usize, self_adjoint: Option<bool>) -> Self {
        Self {
            order,
            self_adjoint,
            is_lagrangian: true,
            takes: MotionClass::Hamiltonian,
            serves_lifts: false,
            correction: Correction::Bisection,
            time_step: None,
        }
    }
}
