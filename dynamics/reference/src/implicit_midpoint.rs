//! The implicit midpoint rule: the part `implicit-midpoint`.

use std::sync::Arc;

use leafwise_core::part::{Compared, Family, PartInfo, PartKind, PartParameters, ServesNumbers};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::Tableau;
use leafwise_core::{BuildError, MotionClass, PoissonSystem, StepMap};

use crate::implicit::gauss_map;

static INFO: PartInfo = PartInfo {
    name: "implicit-midpoint",
    summary: "x+ = x + t X((x + x+)/2)",
    declares: "order 2; self-adjoint; a Poisson map where the tensor is constant or depends \
               on coordinates alone that rest; keeps quadratic \
               invariants; exact tangent",
    domain: "any system, of formulas or of numbers; steps for which the iteration converges",
    literature: "Hairer, Lubich, Wanner, Geometric Numerical Integration, sections II.1 and VI.4",
    family: Some(Family::Implicit),
    takes: MotionClass::OffLeaves,
    serves_numbers: Some(ServesNumbers { rank: 4, limit: "" }),
    compared: Some(Compared::at(6)),
    ..PartInfo::of(PartKind::Stepper)
};

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    gauss_map(system, Tableau::gauss(1), INFO.name.to_owned())
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));
