//! The Cayley chart R = (1 − ½\[q\]×)⁻¹(1 + ½\[q\]×), q = ελp: rational, for every q.

use leafwise_core::lattice::StageEnds;
use leafwise_core::part::{PartInfo, PartKind};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, ChartPoint, ClosedForm, ClosedRealization, PoissonSystem};
use leafwise_expression::{
    AlgebraError, Arithmetic, Function, Graph, Polynomial, Rational, Ring, Term,
};

use crate::source::{LITERATURE, Source};
use crate::tensor::RotationTensor;
use crate::vector::{cross, dot, times};

static INFO: PartInfo = PartInfo {
    name: "so3-cayley",
    summary: "T*SO(3) in the Cayley chart: rational, of degree two in p",
    declares: "exact; self-adjoint",
    domain: "{x1,x2} = -a x3 cyclic with constant a of either sign; every p",
    literature: LITERATURE,
    ..PartInfo::of(PartKind::Realization)
};

/// α = x − ½ x×q + ¼ q (q·x) with q = ελp.
#[derive(Clone, Debug)]
pub struct Cayley {
    tensor: RotationTensor,
}

impl Cayley {
    /// The realization of `system`'s tensor.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] when the tensor is not a constant multiple of that of so(3)*.
    pub fn realize(system: &PoissonSystem) -> Result<ClosedRealization<Self>, BuildError> {
        let tensor = RotationTensor::new(INFO.name, system)?;
        ClosedRealization::new(INFO.name, Self { tensor })
    }
}

/// α's parts, x × q and ¼ q (q·x).
pub(crate) fn source<A: Arithmetic>(
    algebra: &mut A,
    x: &[A::Element],
    q: &[A::Element],
) -> Source<A::Element> {
    let along = dot(algebra, q, x);
    let quarter = algebra.scale(&Rational::new(1, 4), &along);
    Source {
        moment: cross(algebra, x, q),
        even: times(algebra, &quarter, q),
    }
}

/// The same at a point of the chart.
fn parts<A: Arithmetic>(algebra: &mut A, at: &ChartPoint<'_, A::Element>) -> Source<A::Element> {
    let factor = algebra.multiply(at.epsilon, &at.functions[0]);
    let q = times(algebra, &factor, at.p);
    source(algebra, at.x, &q)
}

impl ClosedForm for Cayley {
    fn dimension(&self) -> usize {
        3
    }

    /// λ.
    fn functions(&self, ring: &mut Ring) -> Result<Vec<Polynomial>, BuildError> {
        Ok(vec![self.tensor.factor(ring)?])
    }

    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        Ok(parts(algebra, at).total(algebra, at.x))
    }

    fn ends(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<StageEnds, AlgebraError> {
        Ok(parts(graph, at).ends(graph))
    }
}

/// (1, q/2)/√(1 + θ²/4), the quaternion of the Cayley map.
pub(crate) fn quaternion(graph: &mut Graph, q: &[Term]) -> Result<Vec<Term>, AlgebraError> {
    let square = dot(graph, q, q);
    let one = graph.one();
    let norm = graph.combine(&[
        (Rational::one(), one.clone()),
        (Rational::new(1, 4), square),
    ]);
    let norm = graph.apply(Function::Sqrt, &norm)?;
    let scalar = graph.divide(&one, &norm)?;
    let half = graph.scale(&Rational::new(1, 2), &scalar);
    let mut quaternion = vec![scalar];
    quaternion.extend(times(graph, &half, q));
    Ok(quaternion)
}

leafwise_core::built_in!(RealizationPart::new(&INFO, |system, parameters| {
    parameters.refuse_unknown(&INFO)?;
    Ok(std::sync::Arc::new(Cayley::realize(system)?))
}));
