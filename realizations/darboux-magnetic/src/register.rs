//! The part `darboux-magnetic`.

use std::sync::Arc;

use leafwise_core::part::{
    ParameterDefault, ParameterInfo, ParameterSetting, PartInfo, PartKind, PartParameters,
};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

use crate::realization::DarbouxMagnetic;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "darboux-magnetic",
    kind: PartKind::Realization,
    summary: "the constant realization in Darboux coordinates P = p - A(x) of a magnetic bracket",
    declares: "exact; self-adjoint",
    domain: "all points where A is defined; {x_i, p_j} = -delta_ij or +delta_ij, {p_i, p_j} = \
             B_ij(x) with a global vector potential A: P_i = p_i - A_i commute; over a scene's \
             `magnetic-field` B, whose force is v' = v x B, that is curl A = -B",
    literature: "J. E. Marsden, T. S. Ratiu, Introduction to Mechanics and Symmetry (1999), \
                 section 6.7; Cabrera, Martin de Diego, Vaquero, Approximating Symplectic \
                 Realizations (2024), Example 3",
    parameters: &[ParameterInfo {
        name: "potential",
        summary: "the components of A, one formula a position, separated by `;`, such as \
                  \"0; x^3/3; y^2/2 + x*z\"",
        default: ParameterDefault::Text(""),
    }],
};

struct Part;

impl RealizationPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        match parameters.setting(&INFO, "potential")? {
            ParameterSetting::Text(potential) => {
                Ok(Arc::new(DarbouxMagnetic::new(system, &potential)?))
            }
            // A single number is a constant component.
            number => Ok(Arc::new(DarbouxMagnetic::new(system, &number.to_string())?)),
        }
    }
}

leafwise_core::built_in!(Realization, Part);
