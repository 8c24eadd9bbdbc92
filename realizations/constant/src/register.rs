//! The part `constant`.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

use crate::realization::ConstantRealization;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "constant",
    kind: PartKind::Realization,
    summary: "x -+ (1/2) epsilon Pi p, for tensors without variables",
    declares: "exact; self-adjoint",
    domain: "all points; tensors of numbers and parameters",
    literature: "A. Weinstein, The local structure of Poisson manifolds, J. Differential Geom. 18 \
                 (1983); K. Feng, Difference schemes for Hamiltonian formalism and symplectic \
                 geometry, J. Comput. Math. 4 (1986)",
    parameters: &[],
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
        parameters.refuse_unknown(&INFO)?;
        Ok(Arc::new(ConstantRealization::new(system)?))
    }
}

leafwise_core::built_in!(Realization, Part);
