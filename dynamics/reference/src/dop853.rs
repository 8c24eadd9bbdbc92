//! Dormand and Prince's method of order 8(5,3), adaptive inside a step: the part `dop853`.

use std::sync::Arc;

use leafwise_core::part::{
    Compared, Elsewhere, Family, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::{BuildError, MotionClass, PoissonSystem, StepMap};

use crate::adaptive::{Pair, TOLERANCE, adaptive_map};
use crate::dop853_coefficients::{FIFTH_ORDER_ERROR, MATRIX, THIRD_ORDER_ERROR, WEIGHTS};

static INFO: PartInfo = PartInfo {
    name: "dop853",
    summary: "Dormand-Prince 8(5,3), explicit, adaptive inside each time step",
    declares: "order 8 before the tolerance takes over; not a Poisson map; not self-adjoint",
    domain: "any system, of formulas or of numbers",
    literature: "Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.5; \
                 coefficients of dop853.f (Hairer, Wanner 1994)",
    parameters: &[TOLERANCE],
    family: Some(Family::Explicit),
    takes: MotionClass::OffLeaves,
    serves_numbers: Some(ServesNumbers { rank: 2, limit: "" }),
    compared: Some(Compared::at(3)),
    reference: Some(&[]),
    elsewhere: Some(Elsewhere {
        names: &["dop", "rk8", "rk78", "dopri8"],
        is: "the method of Dormand and Prince of order 8",
    }),
    ..PartInfo::of(PartKind::Stepper)
};

static PAIR: Pair = Pair {
    matrix: &MATRIX,
    weights: WEIGHTS,
    errors: &[FIFTH_ORDER_ERROR, THIRD_ORDER_ERROR],
    order: 8,
    exponent: 8.0,
    first_same_as_last: false,
};

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    adaptive_map(&INFO, &PAIR, system, parameters)
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));
