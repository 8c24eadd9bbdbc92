//! The realization data of a linear or affine tensor.

use std::sync::Arc;

use leafwise_core::part::{Auto, PartInfo, PartKind, PartParameters};
use leafwise_core::realization::{Abilities, Accuracy, EndMaps, EndNumbers, RealizationData};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_karasev::series::KarasevSeries;

use crate::closed_form::ClosedForm;
use crate::evaluator::LiePoissonEvaluator;
use crate::relations::classes;
use crate::structure::NAME;
use crate::structure::StructureConstants;

static INFO: PartInfo = PartInfo {
    name: NAME,
    summary: "the exponential chart of T*G in closed form, for any linear tensor and most affine ones",
    declares: "exact; self-adjoint",
    domain: "epsilon p with every eigenvalue of its coadjoint map of imaginary part below 2 pi and \
             size below 128",
    literature: "M. V. Karasev, Math. USSR Izv. 28 (1987); J. E. Marsden, T. S. Ratiu, \
                 Introduction to Mechanics and Symmetry (1999), chapter 13",
    auto: Some(Auto::Exact {
        rank: 4,
        reason: "the tensor is linear or affine: matrix functions of the coadjoint map",
    }),
    ..PartInfo::of(PartKind::Realization)
};

/// α = Z/(e^Z − 1) x, β = e^Z α with Z = ε A(p), A_ik = Σ_j c_ij^k p_j.
///
/// Both are exact to round-off while every eigenvalue of Z has an imaginary part below 2π and a size
/// below 128; beyond, a step is refused as `LeftChart`. They are code where Z² has one or two roots
/// a coordinate ([`relations`](crate::relations)), numbers otherwise. The chart is Karasev's, and so
/// is the series.
#[derive(Clone, Debug)]
pub struct LiePoisson {
    dimension: usize,
    maps: Maps,
    series: KarasevSeries,
}

/// How α and β are computed.
#[derive(Clone, Debug)]
enum Maps {
    /// One or two roots a class of coordinates.
    Code(ClosedForm),
    /// Every other algebra.
    Numbers(StructureConstants),
}

impl LiePoisson {
    /// The realization data of a system's tensor.
    ///
    /// # Errors
    /// Those of [`StructureConstants::new`]. Returns [`BuildError::DoesNotFit`] for a tensor that is not linear or
    /// affine, and for an affine one on whose central extension Z² has more roots.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        let formulas = system.formulas(INFO.name)?;
        let structure = StructureConstants::new(formulas)?;
        let maps = match classes(&structure, &system.parameter_values()) {
            Some(classes) => Maps::Code(ClosedForm::new(structure, classes)),
            None if structure.is_affine() => {
                return Err(BuildError::DoesNotFit {
                    part: NAME,
                    reason: "the tensor is affine, and its linear extension has no closed form"
                        .to_owned(),
                });
            }
            None => Maps::Numbers(structure),
        };
        Ok(Self {
            dimension: system.dimension(),
            maps,
            series: KarasevSeries::new(formulas.clone()),
        })
    }
}

impl RealizationData for LiePoisson {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Exact
    }

    fn describe(&self) -> String {
        INFO.name.to_owned()
    }

    fn abilities(&self) -> Abilities<'_> {
        let ends = match &self.maps {
            Maps::Code(form) => EndMaps::Code(Box::new(|graph, epsilon, z| {
                form.source_and_target(graph, epsilon, z)
            })),
            Maps::Numbers(structure) => {
                let structure = structure.clone();
                // Shared by several trajectories it would factor at each point twice, for values and for Jacobians.
                let numbers = EndNumbers::new(true, move |parameters, epsilon| {
                    let algebra = structure.at(parameters);
                    Box::new(LiePoissonEvaluator::new(algebra, epsilon))
                });
                EndMaps::Numbers(numbers.with_hessian(|| true).for_one_trajectory())
            }
        };
        Abilities {
            ends: Some(ends),
            series: Some(self.series.source()),
            ..Abilities::default()
        }
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn RealizationData>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    Ok(Arc::new(LiePoisson::new(system)?))
}

leafwise_core::built_in!(RealizationPart::new(&INFO, build));
