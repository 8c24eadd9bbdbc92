//! The parts `karasev-truncated` and `karasev-collocated`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::RealizationPart;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

use crate::collocated::CollocatedKarasev;
use crate::truncated::TruncatedKarasev;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "karasev-truncated",
    kind: PartKind::Realization,
    summary: "Karasev's realization truncated after epsilon^n, for any Poisson tensor",
    declares: "order n: the realization error is O(epsilon^(n+1)); self-adjoint",
    domain: "a neighbourhood of p = 0 where the series decays; any tensor the formulas can say",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, \
                 section 3.2; M. V. Karasev, Math. USSR Izv. 28 (1987)",
    parameters: &[ParameterInfo {
        name: "order",
        summary: "the truncation order n, 1 to 40",
        default: ParameterDefault::Integer(4),
    }],
};

/// Beyond this order round-off of the coefficients exceeds what a further term adds.
const LARGEST_ORDER: i64 = 40;

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
        let order = parameters.get(&INFO, "order")?;
        if !(1..=LARGEST_ORDER).contains(&order) {
            return Err(BuildError::Parameter {
                part: INFO.name,
                parameter: "order".to_owned(),
                value: order.to_string(),
                expected: format!("the truncation order n lies in 1 to {LARGEST_ORDER}"),
            });
        }
        Ok(Arc::new(TruncatedKarasev::new(system, order as usize)?))
    }
}

leafwise_core::built_in!(Realization, Part);

pub(crate) static COLLOCATED: PartInfo = PartInfo {
    name: "karasev-collocated",
    kind: PartKind::Realization,
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
};

struct CollocatedPart;

impl RealizationPart for CollocatedPart {
    fn info(&self) -> &'static PartInfo {
        &COLLOCATED
    }

    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        let points = parameters.get(&COLLOCATED, "points")?;
        if !(0..=24).contains(&points) {
            return Err(BuildError::Parameter {
                part: COLLOCATED.name,
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
}

leafwise_core::built_in!(Realization, CollocatedPart);
