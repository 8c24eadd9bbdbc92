//! The part `lie-poisson`.

use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

use crate::realization::LiePoisson;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "lie-poisson",
    kind: PartKind::Realization,
    summary: "the exponential chart of T*G in closed form, for any linear tensor",
    declares: "exact; self-adjoint",
    domain: "epsilon p with every eigenvalue of its coadjoint map of imaginary part below 2 pi and \
             size below 128",
    literature: "M. V. Karasev, Math. USSR Izv. 28 (1987); J. E. Marsden, T. S. Ratiu, \
                 Introduction to Mechanics and Symmetry (1999), chapter 13",
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
        Ok(Arc::new(LiePoisson::new(system)?))
    }
}

leafwise_core::built_in!(Realization, Part);
