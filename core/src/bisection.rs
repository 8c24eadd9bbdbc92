//! Lagrangian bisections.

use leafwise_expression::{Graph, Term};

use crate::error::{BuildError, StepError};
use crate::generating_function::Generating;

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

/// One thread's evaluator of a closed one-form θ_{ε,h} on M, for fixed parameters, ε and h.
///
/// Both functions take a batch of points y, one behind the other, d numbers each. What is written for a
/// point depends on that point alone.
pub trait OneFormWorker: Send {
    /// p = θ(y), d numbers a point.
    ///
    /// # Errors
    /// [`StepError`] where θ has no value.
    fn value(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError>;
    /// Dθ(y), row-major d × d.
    ///
    /// # Errors
    /// [`StepError::NoTangent`] where it is not offered.
    fn jacobian(&mut self, y: &[f64], jacobian: &mut [f64]) -> Result<(), StepError>;
    /// Whether [`jacobian`](Self::jacobian) is offered.
    fn has_jacobian(&self) -> bool {
        true
    }
    /// Operations so far, as [`SolverStatistics::operations`] counts them; `None` for a part that
    /// does not count.
    ///
    /// [`SolverStatistics::operations`]: crate::SolverStatistics::operations
    fn operations(&self) -> Option<u64> {
        None
    }
}
