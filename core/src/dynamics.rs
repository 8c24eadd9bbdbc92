//! The dynamic approximation.

use std::sync::Arc;

use crate::bisection::LagrangianBisection;
use crate::error::BuildError;
pub use crate::generating_function::{Generating, GeneratingCode, GeneratingFunction};
use crate::realization::RealizationData;
use crate::system::PoissonSystem;

/// Provides a Lagrangian bisection L̂_{ε,h} ↪ (S, ω) that approximates
/// L_{ε,h} = φ_h^{α_ε^*H}(σ(M)) to order m in h (paper, section 4.1).
pub trait DynamicApproximation: Send + Sync + std::fmt::Debug {
    /// m.
    fn order(&self) -> usize;
    /// Whether the induced map is self-adjoint over a realization with β̂(x, p) = α̂(x, −p).
    fn self_adjoint(&self) -> Option<bool>;
    /// Whether L is Lagrangian to round-off: only then is the induced map declared Poisson. Of another L it maps along leaves.
    fn is_lagrangian(&self) -> bool {
        true
    }
    /// Whether it approximates the motion ẋ = −Π(dH + η) of a system with forces η: where it is not said, methods refuse
    /// such a system.
    fn takes_forces(&self) -> bool {
        false
    }
    /// Whether it steps in the coordinates of a [`Lift`](crate::Lift): others need α̂ and β̂.
    fn serves_lifts(&self) -> bool {
        false
    }
    /// Whether y ↦ L(y) is solved for β̂(L(y)) = x, or taken at y = x.
    fn correction(&self) -> Correction {
        Correction::Bisection
    }
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

/// Treatment of the equation β̂(L(y)) = x_k by a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// Solves it: the map is α̂ ∘ (β̂|_L)⁻¹, Poisson over an exact realization.
    Bisection,
    /// Takes y = x_k (paper, Algorithm 2): Poisson to the order of the integrator only.
    None,
}
