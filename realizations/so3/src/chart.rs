//! The cotangent charts of T*SO(3) about the section.

use leafwise_core::BuildError;
use leafwise_core::realization::SourceSeries;
use leafwise_expression::{Graph, Term};
use leafwise_karasev::series::KarasevSeries;

use crate::cayley::{self, CayleySeries};
use crate::exponential;
use crate::tensor::RotationTensor;
use crate::vector::cross;

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
pub(crate) struct Source {
    /// x × q.
    pub moment: Vec<Term>,
    /// The part even in q, without x.
    pub even: Vec<Term>,
}

impl Chart {
    /// The name scenes use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exponential => "exponential",
            Self::Cayley => "cayley",
        }
    }

    pub(crate) fn source(self, graph: &mut Graph, x: &[Term], q: &[Term]) -> Source {
        let moment = cross(graph, x, q);
        let even = match self {
            Self::Exponential => exponential::even_part(graph, &moment, q),
            Self::Cayley => cayley::even_part(graph, x, q),
        };
        Source { moment, even }
    }

    /// The unit quaternion of R(q), scalar part first.
    pub(crate) fn quaternion(self, graph: &mut Graph, q: &[Term]) -> Result<Vec<Term>, BuildError> {
        match self {
            Self::Exponential => Ok(exponential::quaternion(graph, q)),
            Self::Cayley => Ok(cayley::quaternion(graph, q)?),
        }
    }

    /// α along p(h): the exponential chart is Karasev's.
    pub(crate) fn series(self, tensor: &RotationTensor) -> ChartSeries {
        match self {
            Self::Exponential => {
                ChartSeries::Exponential(KarasevSeries::new(tensor.system().clone()))
            }
            Self::Cayley => ChartSeries::Cayley(CayleySeries::new(tensor.clone())),
        }
    }
}

/// The series of a chart's source.
#[derive(Clone, Debug)]
pub(crate) enum ChartSeries {
    Exponential(KarasevSeries),
    Cayley(CayleySeries),
}

impl ChartSeries {
    pub(crate) fn as_dyn(&self) -> &dyn SourceSeries {
        match self {
            Self::Exponential(series) => series,
            Self::Cayley(series) => series,
        }
    }
}
