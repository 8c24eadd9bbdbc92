//! Gauss methods: the part `gauss`.

use std::sync::Arc;

use leafwise_core::part::{
    Compared, Family, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters,
    ServesNumbers,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::Tableau;
use leafwise_core::{BuildError, MotionClass, PoissonSystem, StepMap};

use crate::implicit::gauss_map;

static INFO: PartInfo = PartInfo {
    name: "gauss",
    summary: "collocation at s Gauss nodes",
    declares: "order 2s; self-adjoint; a Poisson map where the tensor is constant or depends \
               on coordinates alone that rest; keeps quadratic \
               invariants; exact tangent",
    domain: "any system, of formulas or of numbers; steps for which the iteration converges",
    literature: "J. C. Butcher, Math. Comp. 18 (1964); Hairer, Lubich, Wanner, Geometric \
                 Numerical Integration, sections II.1.3 and VI.4",
    parameters: &[STAGES],
    family: Some(Family::Implicit),
    takes: MotionClass::OffLeaves,
    serves_numbers: Some(ServesNumbers { rank: 5, limit: "" }),
    compared: Some(Compared {
        settings: &[
            &[("stages", ParameterDefault::Integer(2))],
            &[("stages", ParameterDefault::Integer(3))],
        ],
        ..Compared::at(7)
    }),
    reference: Some(&[("stages", ParameterDefault::Integer(8))]),
    surveyed: &[
        &[("stages", ParameterDefault::Integer(1))],
        &[("stages", ParameterDefault::Integer(2))],
        &[("stages", ParameterDefault::Integer(3))],
        &[("stages", ParameterDefault::Integer(4))],
    ],
    ..PartInfo::of(PartKind::Stepper)
};

/// The parameter `stages`.
pub(crate) const STAGES: ParameterInfo = ParameterInfo {
    name: "stages",
    summary: "the stages s of a Gauss method, 1 to 16",
    default: ParameterDefault::Integer(2),
};

/// The stages asked for.
///
/// # Errors
/// [`BuildError::Parameter`] outside 1 to 16.
pub(crate) fn stages(
    info: &'static PartInfo,
    parameters: &PartParameters,
) -> Result<usize, BuildError> {
    let stages = parameters.get(info, STAGES.name)?;
    usize::try_from(stages)
        .ok()
        .filter(|stages| (1..=Tableau::MOST_STAGES).contains(stages))
        .ok_or_else(|| BuildError::Parameter {
            part: info.name,
            parameter: STAGES.name.to_owned(),
            value: stages.to_string(),
            expected: format!("the number of stages lies in 1 to {}", Tableau::MOST_STAGES),
        })
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let stages = stages(&INFO, parameters)?;
    let description = format!("{} s = {stages}", INFO.name);
    gauss_map(system, Tableau::gauss(stages), description)
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));
