//! T*SO(3) itself: points are a unit quaternion and a momentum.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::realization::{
    Abilities, Accuracy, EndMaps, RealizationData, SourceTarget, Space, SpaceChart,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::{Arithmetic, Function, Graph, Rational, Term};

use crate::chart::Chart;
use crate::exponential::guard;
use crate::source::LITERATURE;
use crate::tensor::RotationTensor;
use crate::vector::cross;

static INFO: PartInfo = PartInfo {
    name: "so3-group",
    summary: "T*SO(3) as pairs of a unit quaternion and a momentum",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; every rotation, in the \
             exponential chart those by an angle below 2 pi, checked",
    literature: LITERATURE,
    parameters: &[ParameterInfo {
        name: "chart",
        summary: "the chart of rotations about the section: cayley or exponential",
        default: ParameterDefault::Text("cayley"),
    }],
    points_are_pairs: false,
    surveyed: &[
        &[("chart", ParameterDefault::Text("cayley"))],
        &[("chart", ParameterDefault::Text("exponential"))],
    ],
    ..PartInfo::of(PartKind::Realization)
};

/// (T*SO(3), ω, α, β, σ): α(R, m) = m, β(R, m) = Rᵀm, σ(x) = (1, x), R held as the unit quaternion
/// (q0, v), z = (q0, v, m).
///
/// Functions on T*M reach it through χ(x, p) = (R(ελp), α_ε(x, p)) in a chart of rotations. The
/// compositions α∘χ and β∘χ are those of the realization on T*so(3)* in the same chart.
#[derive(Clone, Debug)]
pub struct So3Group {
    chart: Chart,
    tensor: RotationTensor,
    /// The realization on T*so(3)* in the same chart.
    flat: Arc<dyn RealizationData>,
}

impl So3Group {
    /// The realization of `system`'s tensor, χ in this chart of rotations.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] when the tensor is not a constant multiple of that of so(3)*.
    pub fn new(system: &PoissonSystem, chart: Chart) -> Result<Self, BuildError> {
        let tensor = RotationTensor::new(INFO.name, system)?;
        Ok(Self {
            flat: chart.realize(system)?,
            chart,
            tensor,
        })
    }

    /// The chart of rotations behind χ.
    pub fn chart_of_rotations(&self) -> Chart {
        self.chart
    }
}

impl RealizationData for So3Group {
    fn dimension(&self) -> usize {
        3
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        format!("{} chart = {}", INFO.name, self.chart.name())
    }

    fn section(&self, x: &[f64], z: &mut [f64]) {
        z[..4].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
        z[4..].copy_from_slice(x);
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            space: Space::Points {
                coordinates: 7,
                chart: Some(SpaceChart::Code(Box::new(|graph, epsilon, x, p| {
                    self.point(graph, epsilon, x, p)
                }))),
            },
            ends: Some(EndMaps::Code(Box::new(|graph, epsilon, z| {
                self.source_and_target(graph, epsilon, z)
            }))),
            series: self.flat.abilities().series,
            ..Abilities::default()
        }
    }
}

impl So3Group {
    fn source_and_target(
        &self,
        graph: &mut Graph,
        _epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let (rotation, m) = z.split_at(4);
        let (scalar, vector) = (&rotation[0], &rotation[1..]);
        // Rᵀm − m = 2 v×(v×m) − 2 q0 v×m, of the size of a step.
        let once = cross(graph, vector, m);
        let twice = cross(graph, vector, &once);
        let mut offset = Vec::with_capacity(3);
        for (twice, once) in twice.into_iter().zip(&once) {
            let turned = graph.multiply(scalar, once);
            offset.push(graph.combine(&[
                (Rational::from_integer(2), twice),
                (Rational::from_integer(-2), turned),
            ]));
        }
        let increment = offset.iter().map(|o| graph.negate(o)).collect();
        let guard = match self.chart {
            Chart::Cayley => None,
            Chart::Exponential => {
                let half = graph.apply(Function::Acos, scalar)?;
                let angle = graph.scale(&Rational::from_integer(2), &half);
                Some(guard(graph, angle))
            }
        };
        Ok(SourceTarget {
            base: m.to_vec(),
            offset,
            increment,
            guard,
        })
    }
}

impl So3Group {
    fn point(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        x: &[Term],
        p: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let q = self.tensor.scaled_momentum(graph, epsilon, p)?;
        let mut point = self.chart.quaternion(graph, &q)?;
        let source = self.chart.source(graph, x, &q);
        point.extend(source.total(graph, x));
        Ok(point)
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    let chart = match parameters.word(&INFO, "chart", &["cayley", "exponential"])? {
        "cayley" => Chart::Cayley,
        _ => Chart::Exponential,
    };
    Ok(Arc::new(So3Group::new(system, chart)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
