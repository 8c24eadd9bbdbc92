//! Lagrangian bisections: the dynamic approximation.

use std::sync::Arc;

use leafwise_expression::{Graph, Polynomial, Ring, Term};

use crate::error::BuildError;
use crate::realization::RealizationData;
use crate::system::PoissonSystem;

/// Provides a Lagrangian bisection L̂_{ε,h} ↪ (S, ω) that approximates
/// L_{ε,h} = φ_h^{α_ε^*H}(σ(M)) to order m in h (paper, section 4.1).
pub trait DynamicApproximation: Send + Sync + std::fmt::Debug {
    /// m.
    fn order(&self) -> usize;
    /// One line for reports: name and order.
    fn describe(&self) -> String;
    /// The bisection for this system and realization.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] when the realization lacks what this approximation needs.
    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &dyn RealizationData,
    ) -> Result<Arc<dyn LagrangianBisection>, BuildError>;
}

/// A parametrization y ↦ L(y) ∈ S of a Lagrangian bisection: y ↦ (y, dŜ(y)) for Hamilton–Jacobi,
/// y ↦ Σ_h(σ(y)) for a collective integrator.
pub trait LagrangianBisection: Send + Sync + std::fmt::Debug {
    /// y ↦ L(y) as straight-line code.
    fn code(&self) -> Option<&dyn BisectionCode> {
        None
    }
    /// The generating function, where L is the graph of dŜ.
    fn generating_function(&self) -> Option<&GeneratingFunction> {
        None
    }
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

/// Ŝ_{ε,h} = Σ_{l odd} ε^{l−1} hˡ S_l in exact algebra (paper, section 4.2; only odd l by
/// Proposition 1).
#[derive(Clone, Debug)]
pub struct GeneratingFunction {
    /// The ring the coefficients live in.
    pub ring: Ring,
    /// S_1, S_3, … at ε = 1.
    pub coefficients: Vec<Polynomial>,
    /// dS_1, dS_3, …: d components each.
    pub gradients: Vec<Vec<Polynomial>>,
}
