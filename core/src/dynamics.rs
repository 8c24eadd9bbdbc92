//! Lagrangian bisections: the dynamic approximation.

use std::sync::Arc;

use leafwise_expression::{Graph, Term};

use crate::error::{BuildError, StepError};
pub use crate::generating_function::{Generating, GeneratingCode, GeneratingFunction};
use crate::one_form::OneFormWorker;
use crate::realization::RealizationData;
use crate::system::PoissonSystem;

/// Provides a Lagrangian bisection L̂_{ε,h} ↪ (S, ω) that approximates
/// L_{ε,h} = φ_h^{α_ε^*H}(σ(M)) to order m in h (paper, section 4.1).
pub trait DynamicApproximation: Send + Sync + std::fmt::Debug {
    /// m.
    fn order(&self) -> usize;
    /// Whether the induced map is self-adjoint over a realization with β̂(x, p) = α̂(x, −p).
    fn self_adjoint(&self) -> Option<bool>;
    /// Whether L is Lagrangian to round-off: only then is the induced map declared Poisson.
    fn is_lagrangian(&self) -> bool {
        true
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
    ) -> Result<Arc<dyn LagrangianBisection>, BuildError>;
}

/// What a method does with β̂(L(y)) = x_k.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// Solves it: the map is α̂ ∘ (β̂|_L)⁻¹, Poisson over an exact realization.
    Bisection,
    /// Takes y = x_k (paper, Algorithm 2): Poisson to the order of the integrator only.
    None,
}

/// A parametrization y ↦ L(y) ∈ S of a Lagrangian bisection: y ↦ (y, dŜ(y)) for Hamilton–Jacobi,
/// y ↦ Σ_h(σ(y)) for a collective integrator.
pub trait LagrangianBisection: Send + Sync + std::fmt::Debug {
    /// y ↦ L(y) as straight-line code.
    fn code(&self) -> Option<&dyn BisectionCode> {
        None
    }
    /// y ↦ L(y) as numbers, for a bisection that offers no code.
    fn worker(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn BisectionWorker>> {
        let _ = (parameters, epsilon, h);
        None
    }
    /// θ as numbers, where L is the graph of a one-form in the realization's chart and offers no code.
    fn one_form(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn OneFormWorker>> {
        let _ = (parameters, epsilon, h);
        None
    }
    /// The generating function, where L is the graph of dŜ.
    fn generating_function(&self) -> Option<&Generating> {
        None
    }
}

/// One thread's evaluator of a bisection, for fixed parameters, ε and h.
pub trait BisectionWorker: Send {
    /// L(y), d_S numbers.
    ///
    /// # Errors
    /// [`StepError`] when the integrator behind it does not converge.
    fn point(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError>;
    /// DL at the point of the last call, row-major d_S × d.
    ///
    /// # Errors
    /// [`StepError`] where the tangent does not exist.
    fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), StepError>;
    /// Whether [`tangent`](Self::tangent) is offered: Newton's method and exact tangents of steps
    /// need it.
    fn has_tangent(&self) -> bool {
        true
    }
    /// Whether D(β̂∘L) is so near the identity that the residual serves as the correction.
    fn is_near_identity(&self) -> bool {
        false
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a part that
    /// does not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64> {
        None
    }
    /// The same map at many points in one call, for a worker whose values at a point depend on that
    /// point alone: trajectories with the same parameters then share it.
    fn batch(&mut self) -> Option<&mut dyn BisectionBatch> {
        None
    }
    /// Forgets earlier evaluations: the next one starts cold.
    fn restart(&mut self) {}
    /// What later evaluations depend on, for a checkpoint; always of the same length.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, memory: &[f64]) {
        let _ = memory;
    }
}

/// y ↦ L(y) at many points of M, one behind the other; bit for bit what [`BisectionWorker`] gives.
pub trait BisectionBatch: Send {
    /// L at each y of d numbers: d_S numbers a point.
    ///
    /// # Errors
    /// As [`BisectionWorker::point`] at one of the points, with `z` unspecified.
    fn all_points(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError>;
    /// DL at each y, row-major d_S × d.
    ///
    /// # Errors
    /// As [`BisectionWorker::tangent`] at one of the points, with `tangents` unspecified.
    fn all_tangents(&mut self, y: &[f64], tangents: &mut [f64]) -> Result<(), StepError>;
}

/// A bisection as straight-line code.
pub trait BisectionCode {
    /// The d_S coordinates of L_{ε,h}(y).
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the Hamiltonian has no code.
    fn point(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        h: &Term,
        y: &[Term],
    ) -> Result<Vec<Term>, BuildError>;
}
