//! The cotangent charts of T*SO(3) about the section.

use std::sync::Arc;

use leafwise_core::{BuildError, PoissonSystem, RealizationData};
use leafwise_expression::{Arithmetic, Graph, Rational, Term};

use crate::cayley::{self, Cayley};
use crate::exponential::{self, So3Exponential};

/// Where T*SO(3) is treated.
pub(crate) const LITERATURE: &str = "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic \
                          Realizations, section 2; Marsden, Ratiu, Introduction to Mechanics and \
                          Symmetry, chapters 13 and 15";

/// A parametrization q ↦ R(q) of SO(3) with R(−q) = R(q)ᵀ, and with it a symplectic chart
/// (x, p) ↦ (R(εp), α_ε(x, p)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// R = exp \[q\]×, ‖q‖ < 2π.
    Exponential,
    /// R = (1 − ½\[q\]×)⁻¹(1 + ½\[q\]×).
    Cayley,
}

/// α = x − ½ moment + even.
pub(crate) struct Source<E> {
    /// x × q.
    pub moment: Vec<E>,
    /// The part even in q, without x.
    pub even: Vec<E>,
}

impl<E: Clone> Source<E> {
    /// α.
    pub(crate) fn total<A: Arithmetic<Element = E>>(&self, algebra: &mut A, x: &[E]) -> Vec<E> {
        let mut component = |i: usize| {
            algebra.combine(&[
                (Rational::one(), x[i].clone()),
                (Rational::new(-1, 2), self.moment[i].clone()),
                (Rational::one(), self.even[i].clone()),
            ])
        };
        (0..3).map(&mut component).collect()
    }
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
