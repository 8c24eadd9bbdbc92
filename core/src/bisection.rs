//! Bisections, Lagrangian where maps are Poisson.

use leafwise_expression::{Graph, Term};

use crate::error::BuildError;
use crate::evaluator::Evaluator;
use crate::generating_function::Generating;

/// A parametrization y ↦ L(y) ∈ S of a Lagrangian bisection: y ↦ (y, dŜ(y)) for Hamilton–Jacobi,
/// y ↦ Σ_h(σ(y)) for a collective integrator. Of a one-form θ that is not closed, y ↦ (y, θ(y)) is none, and
/// [`is_lagrangian`](crate::DynamicApproximation::is_lagrangian) says so.
pub trait LagrangianBisection: Send + Sync + std::fmt::Debug {
    /// y ↦ L(y) as straight-line code.
    fn code(&self) -> Option<PointCode<'_>> {
        None
    }
    /// y ↦ L(y) as numbers, for a bisection that offers no code.
    fn evaluator(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        let _ = (parameters, epsilon, h);
        None
    }
    /// The one-form y ↦ θ(y) as code, of a graph, ε, h and y, where L is its graph in the realization's chart.
    fn one_form_code(&self) -> Option<PointCode<'_>> {
        None
    }
    /// The same as numbers, where it offers no code.
    fn one_form(&self, parameters: &[f64], epsilon: f64, h: f64) -> Option<Box<dyn Evaluator>> {
        let _ = (parameters, epsilon, h);
        None
    }
    /// Whether D(β̂∘L) is so near the identity that the residual serves as the correction.
    fn is_near_identity(&self) -> bool {
        false
    }
    /// The number of stages of the Gauss method that steps H∘α̂ in the coordinates of a [`Lift`](crate::lift::Lift), where L is
    /// given by it alone: 1 to [`Tableau::MOST_STAGES`](crate::runge_kutta::Tableau::MOST_STAGES).
    fn lifted_by(&self) -> Option<usize> {
        None
    }
    /// The generating function, where L is the graph of dŜ.
    fn generating_function(&self) -> Option<&Generating> {
        None
    }
}

/// A bisection or a one-form as straight-line code: of a graph, ε, h and y, the d_S coordinates of L_{ε,h}(y).
///
/// It fails with [`BuildError::Algebra`] where the Hamiltonian has no code.
pub type PointCode<'a> =
    Box<dyn Fn(&mut Graph, &Term, &Term, &[Term]) -> Result<Vec<Term>, BuildError> + 'a>;
