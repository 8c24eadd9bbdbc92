//! The realizations of so(3)* on T*so(3)*, in either chart.

use std::sync::Arc;

use leafwise_core::part::{Auto, PartInfo, PartKind};
use leafwise_core::realization::{
    Accuracy, RealizationCode, RealizationData, SourceSeries, SourceTarget,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::{Arithmetic, Function, Graph, Rational, Term};

use crate::chart::{Chart, ChartSeries, LITERATURE};
use crate::exponential::guard;
use crate::tensor::RotationTensor;
use crate::vector::dot;

static EXPONENTIAL: PartInfo = PartInfo {
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

static CAYLEY: PartInfo = PartInfo {
    name: "so3-cayley",
    summary: "T*SO(3) in the Cayley chart: rational, of degree two in p",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; every p",
    literature: LITERATURE,
    ..PartInfo::of(PartKind::Realization)
};

/// (T*so(3)* ⊃ U, ω_M, α, β, σ) with q = ελp and, at β(x, p) = α(x, −p),
///
/// - exponential chart: α = x − ½ x×q + c (x×q)×q, c = (1 − (θ/2) cot(θ/2))/θ², θ = ‖q‖ < 2π;
/// - Cayley chart: α = x − ½ x×q + ¼ q (q·x).
///
/// The odd part is orthogonal to x + even part, which keeps the Casimir |x|² whatever the rounding
/// of the coefficient.
#[derive(Clone, Debug)]
pub struct So3Cotangent {
    chart: Chart,
    tensor: RotationTensor,
    series: ChartSeries,
}

impl So3Cotangent {
    /// The realization of `system`'s tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] when the tensor is not a constant multiple of that of so(3)*.
    pub fn new(system: &PoissonSystem, chart: Chart) -> Result<Self, BuildError> {
        let tensor = RotationTensor::new(info(chart).name, system)?;
        Ok(Self {
            series: chart.series(&tensor),
            chart,
            tensor,
        })
    }

    /// The chart.
    pub fn chart_of_rotations(&self) -> Chart {
        self.chart
    }
}

impl RealizationData for So3Cotangent {
    fn dimension(&self) -> usize {
        3
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        info(self.chart).name.to_owned()
    }

    fn code(&self) -> Option<&dyn RealizationCode> {
        Some(self)
    }

    fn series(&self) -> Option<&dyn SourceSeries> {
        Some(self.series.as_dyn())
    }
}

impl RealizationCode for So3Cotangent {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (x, p) = z.split_at(3);
        let q = self.tensor.scaled_momentum(graph, epsilon, p)?;
        let source = self.chart.source(graph, x, &q);
        let offset = source
            .even
            .iter()
            .zip(&source.moment)
            .map(|(even, moment)| {
                let terms = [
                    (Rational::one(), even.clone()),
                    (Rational::new(1, 2), moment.clone()),
                ];
                graph.combine(&terms)
            })
            .collect();
        let increment = source.moment.iter().map(|w| graph.negate(w)).collect();
        let guard = match self.chart {
            Chart::Cayley => None,
            Chart::Exponential => {
                let square = dot(graph, &q, &q);
                let angle = graph.apply(Function::Sqrt, &square)?;
                Some(guard(graph, angle))
            }
        };
        Ok(SourceTarget {
            base: x.to_vec(),
            offset,
            increment,
            guard,
        })
    }
}

fn info(chart: Chart) -> &'static PartInfo {
    match chart {
        Chart::Exponential => &EXPONENTIAL,
        Chart::Cayley => &CAYLEY,
    }
}

fn part(chart: Chart) -> RealizationPart {
    RealizationPart::new(info(chart), move |system, parameters| {
        parameters.refuse_unknown(info(chart))?;
        Ok(Arc::new(So3Cotangent::new(system, chart)?))
    })
}

leafwise_core::built_in!(part(Chart::Exponential));
leafwise_core::built_in!(part(Chart::Cayley));
