//! The part `karasev-truncated`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::{BuiltIn, RealizationPart};
use leafwise_core::{BuildError, PoissonSystem, RealizationData};

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

inventory::submit! { BuiltIn::Realization(&Part) }
