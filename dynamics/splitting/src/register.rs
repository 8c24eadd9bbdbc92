//! The part `splitting`.

use std::sync::Arc;

use leafwise_core::lattice::{LatticeMap, LatticeSource};
use leafwise_core::part::{PartInfo, PartKind, PartParameters};
use leafwise_core::registry::StepperPart;
use leafwise_core::solver::StepMap;
use leafwise_core::{BuildError, PoissonSystem};

use crate::lattice::LatticeSplitting;
use crate::splitting::Splitting;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "splitting",
    kind: PartKind::Stepper,
    summary: "Strang's product of exact flows of the Hamiltonian's pieces, found from the formulas",
    declares: "order 2; self-adjoint; exactly Poisson; explicit",
    domain: "Hamiltonians whose terms have flows that are polynomial, exponential or rotations",
    literature: "Strang, On the construction and comparison of difference schemes (1968); \
                 McLachlan, Quispel, Splitting methods, Acta Numerica 11 (2002); Hairer, Lubich, \
                 Wanner, Geometric Numerical Integration, section VII.4.2",
    parameters: &[],
};

struct Part;

impl StepperPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        parameters.refuse_unknown(&INFO)?;
        Ok(Arc::new(Splitting::new(system)?))
    }

    fn build_on_lattice(
        &self,
        source: &dyn LatticeSource,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn LatticeMap>, BuildError> {
        parameters.refuse_unknown(&INFO)?;
        Ok(Arc::new(LatticeSplitting::new(source)?))
    }
}

leafwise_core::built_in!(Stepper, Part);
