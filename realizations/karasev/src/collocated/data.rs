//! Karasev's realization data, numerically exact.

use std::sync::Arc;

use leafwise_core::part::{
    Auto, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{
    Abilities, Accuracy, BuildError, EndMaps, EndNumbers, PoissonSystem, RealizationData,
};

use super::collocation::Collocation;
use super::evaluator::CollocatedEvaluator;
use super::field::{Field, NAME};
use super::fused::FusedStep;
use crate::series::KarasevSeries;

static INFO: PartInfo = PartInfo {
    name: NAME,
    summary: "Karasev's realization by collocation at Gauss nodes: numerically exact, any tensor",
    declares: "exact to round-off with points = 0 (as many nodes as the step needs); with q nodes \
               the bracket defect is O(epsilon^(2q)); self-adjoint",
    domain: "where the curve of the step can be resolved by 24 nodes; any tensor, of formulas or \
             of numbers",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, \
                 section 3.2, remark on other approximations; M. V. Karasev, Math. USSR Izv. 28 \
                 (1987)",
    parameters: &[ParameterInfo {
        name: "points",
        summary: "the number q of Gauss nodes, 1 to 24; 0: as many as the step needs",
        default: ParameterDefault::Integer(0),
    }],
    auto: Some(Auto::Exact {
        rank: 5,
        reason: "the tensor has no closed form here: collocation, exact to round-off",
    }),
    serves_numbers: Some(ServesNumbers { rank: 1, limit: "" }),
    surveyed: &[
        &[("points", ParameterDefault::Integer(0))],
        &[("points", ParameterDefault::Integer(1))],
        &[("points", ParameterDefault::Integer(2))],
        &[("points", ParameterDefault::Integer(3))],
    ],
    ..PartInfo::of(PartKind::Realization)
};

/// K_ε = (S ⊂ T*M, ω_M, α_ε, β_ε, σ) by collocation at q Gauss nodes, for any tensor with values
/// of Π(y)p; its tangents where the tensor has first derivatives.
///
/// With a fixed q the bracket defect of α̂ is O(ε^{2q}); the automatic choice adds nodes until the
/// defect is at round-off for the step at hand.
#[derive(Clone, Debug)]
pub struct CollocatedKarasev {
    collocation: Collocation,
    /// Where the tensor is a formula.
    series: Option<KarasevSeries>,
}

impl CollocatedKarasev {
    /// The realization at `points` nodes, or at as many as the step needs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor has no code.
    pub fn new(system: &PoissonSystem, points: Option<usize>) -> Result<Self, BuildError> {
        let formulas = system.expressions();
        Ok(Self {
            collocation: Collocation {
                field: Field::of(system)?,
                points,
            },
            series: formulas.map(|formulas| KarasevSeries::new(formulas.clone())),
        })
    }
}

impl RealizationData for CollocatedKarasev {
    fn dimension(&self) -> usize {
        self.collocation.dimension()
    }

    fn accuracy(&self) -> Accuracy {
        match self.collocation.points {
            None => Accuracy::Exact,
            Some(q) => Accuracy::Order(2 * q - 1),
        }
    }

    fn describe(&self) -> String {
        match self.collocation.points {
            None => format!("{NAME} (as many nodes as needed)"),
            Some(q) => format!("{NAME} q = {q}"),
        }
    }

    fn abilities(&self) -> Abilities<'_> {
        let collocation = self.collocation.clone();
        let field = collocation.field.clone();
        Abilities {
            // Curves start from those before.
            ends: Some(EndMaps::Numbers(
                EndNumbers::new(
                    collocation.field.has_slopes(),
                    move |parameters, epsilon| {
                        let curve = collocation.curve(parameters);
                        let (most, d) = (collocation.most_points(), collocation.dimension());
                        Box::new(CollocatedEvaluator::new(curve, epsilon, most, d))
                    },
                )
                .with_hessian(move || field.has_curvatures())
                .for_one_trajectory(),
            )),
            fused: Some(Box::new(|system, form, properties| {
                let describe = format!("{} + Hamilton-Jacobi, fused", self.describe());
                let form = form.map(system.dimension(), system.parameters().len())?;
                let collocation = self.collocation.clone();
                Ok(Arc::new(FusedStep::new(
                    collocation,
                    describe,
                    form,
                    properties,
                )))
            })),
            series: self.series.as_ref().map(KarasevSeries::source),
            ..Abilities::default()
        }
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    let points = parameters.get(&INFO, "points")?;
    if !(0..=24).contains(&points) {
        return Err(BuildError::Parameter {
            part: INFO.name,
            parameter: "points".to_owned(),
            value: points.to_string(),
            expected: "the number of nodes lies in 1 to 24; 0 leaves it open".to_owned(),
        });
    }
    let points = if points == 0 {
        None
    } else {
        Some(points as usize)
    };
    Ok(Arc::new(CollocatedKarasev::new(system, points)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
