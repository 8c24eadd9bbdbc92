//! The cotangent charts of T*SO(3) about the section.

use std::sync::Arc;

use leafwise_core::{BuildError, PoissonSystem, RealizationData};
use leafwise_expression::{Graph, Term};

use crate::cayley::{self, Cayley};
use crate::exponential::{self, So3Exponential};
use crate::source::Source;

/// A parametrization q ↦ R(q) of SO(3) with R(−q) = R(q)ᵀ, and with it a symplectic chart
/// (x, p) ↦ (R(εp), α_ε(x, p)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// R = exp \[q\]×, ‖q‖ < 2π.
    Exponential,
    /// R = (1 − ½\[q\]×)⁻¹(1 + ½\[q\]×).
    Cayley,
}

impl Chart {
    /// The name scenes use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exponential => "exponential",
            Self::Cayley => "cayley",
        }
    }

    /// The realization on T*so(3)* in this chart.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] when the tensor is not a constant multiple of that of so(3)*.
    pub fn realize(self, system: &PoissonSystem) -> Result<Arc<dyn RealizationData>, BuildError> {
        Ok(match self {
            Self::Exponential => Arc::new(So3Exponential::new(system)?),
            Self::Cayley => Arc::new(Cayley::realize(system)?),
        })
    }

    pub(crate) fn source(self, graph: &mut Graph, x: &[Term], q: &[Term]) -> Source<Term> {
        match self {
            Self::Exponential => exponential::source(graph, x, q),
            Self::Cayley => cayley::source(graph, x, q),
        }
    }

    /// The unit quaternion of R(q), scalar part first.
    pub(crate) fn quaternion(self, graph: &mut Graph, q: &[Term]) -> Result<Vec<Term>, BuildError> {
        match self {
            Self::Exponential => Ok(exponential::quaternion(graph, q)),
            Self::Cayley => Ok(cayley::quaternion(graph, q)?),
        }
    }
}
