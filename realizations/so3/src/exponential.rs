//! The exponential chart R = exp \[q\]×, q = ελp: Karasev's realization in closed form.

use leafwise_core::lattice::StageEnds;
use leafwise_core::part::{Auto, PartInfo, PartKind};
use leafwise_core::realization::{Abilities, Accuracy, EndMaps, RealizationData, SourceTarget};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::{Arithmetic, Function, Graph, Rational, Term};
use leafwise_karasev::series::KarasevSeries;

use crate::functions::{HALF_COSINE, HALF_SINE, cotangent_coefficient};
use crate::source::{LITERATURE, Source};
use crate::tensor::RotationTensor;
use crate::vector::{cross, dot, times};

static INFO: PartInfo = PartInfo {
    name: "so3-exponential",
    summary: "T*SO(3) in the exponential chart: Karasev's realization of so(3)*, summed",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; eps*|a|*|p| < 2 pi, checked",
    literature: LITERATURE,
    auto: Some(Auto::Exact {
        rank: 3,
        reason: "the tensor is that of so(3)*: a closed form",
    }),
    ..PartInfo::of(PartKind::Realization)
};

/// (T*so(3)* ⊃ U, ω_M, α, β, σ) with β(x, p) = α(x, −p) and, for q = ελp, α = x − ½ x×q +
/// c (x×q)×q. The coefficient is c = (1 − (θ/2) cot(θ/2))/θ², θ = ‖q‖ < 2π.
///
/// The odd part is orthogonal to x + even part, which keeps the Casimir |x|² whatever the rounding
/// of the coefficient.
#[derive(Clone, Debug)]
pub struct So3Exponential {
    tensor: RotationTensor,
    series: KarasevSeries,
}

impl So3Exponential {
    /// The realization of `system`'s tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] when the tensor is not a constant multiple of that of so(3)*.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let tensor = RotationTensor::new(INFO.name, system)?;
        Ok(Self {
            series: KarasevSeries::new(tensor.system().clone()),
            tensor,
        })
    }
}

impl RealizationData for So3Exponential {
    fn dimension(&self) -> usize {
        3
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            series: Some(self.series.source()),
            ..Abilities::default()
        }
    }
}

impl So3Exponential {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(3);
        let q = self.tensor.scaled_momentum(graph, epsilon, p)?;
        let source = source(graph, x, &q);
        let StageEnds { offset, increment } = source.ends(graph);
        let square = dot(graph, &q, &q);
        let angle = graph.apply(Function::Sqrt, &square)?;
        let guard = Some(guard(graph, angle));
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard,
        })
    }
}

/// θ/2π at which the chart is declared left: 1 − 2⁻¹⁰. There c has lost ten bits, since its
/// relative condition in θ² is θ²/(4π² − θ²).
const WALL: (i64, i64) = (1023, 1024);

/// α's parts, x × q and c (x×q)×q.
pub(crate) fn source(graph: &mut Graph, x: &[Term], q: &[Term]) -> Source<Term> {
    let moment = cross(graph, x, q);
    let square = dot(graph, q, q);
    let coefficient = cotangent_coefficient(graph, &square);
    let twice = cross(graph, &moment, q);
    Source {
        even: times(graph, &coefficient, &twice),
        moment,
    }
}

/// (cos(θ/2), sin(θ/2) q/θ), the quaternion of exp \[q\]×.
pub(crate) fn quaternion(graph: &mut Graph, q: &[Term]) -> Vec<Term> {
    let square = dot(graph, q, q);
    let sine = graph.apply_analytic(HALF_SINE, 0, &square);
    let mut quaternion = vec![graph.apply_analytic(HALF_COSINE, 0, &square)];
    quaternion.extend(times(graph, &sine, q));
    quaternion
}

/// The chart's radius 2π (1 − 2⁻¹⁰) against the angle.
pub(crate) fn guard(graph: &mut Graph, angle: Term) -> (Vec<Term>, Vec<Term>) {
    let pi = graph.pi();
    let radius = graph.scale(&Rational::new(2 * WALL.0, WALL.1), &pi);
    (vec![radius], vec![angle])
}

leafwise_core::built_in!(RealizationPart::new(&INFO, |system, parameters| {
    parameters.refuse_unknown(&INFO)?;
    Ok(std::sync::Arc::new(So3Exponential::new(system)?))
}));
