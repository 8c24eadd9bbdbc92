//! The part `log-canonical`.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

use crate::realization::LogCanonical;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "log-canonical",
    kind: PartKind::Realization,
    summary: "x exp(-+ (1/2) epsilon sum_j a_ij x_j p_j), for {x_i, x_j} = a_ij x_i x_j",
    declares: "exact; self-adjoint",
    domain: "all points where the exponentials are finite; a_ij of numbers and parameters",
    literature: "S. Li, D. Rupel, Symplectic groupoids for cluster manifolds, arXiv:1807.03450 \
                 (2018)",
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
        Ok(Arc::new(LogCanonical::new(system)?))
    }
}

leafwise_core::built_in!(Realization, Part);
