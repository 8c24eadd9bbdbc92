//! The part `hamilton-jacobi`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{BuildError, DynamicApproximation};

use crate::bisection::HamiltonJacobi;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "hamilton-jacobi",
    kind: PartKind::Dynamics,
    summary: "graph of dS, S the truncated solution of the Hamilton-Jacobi equation",
    declares: "order m (even); self-adjoint; exactly Poisson over an exact realization",
    domain: "realizations with a cotangent chart; Hamiltonians the formulas can say, of order 2 \
             also systems of numbers",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, \
                 section 4.2; Ferraro, de Leon, Marrero, Martin de Diego, Vaquero, On the \
                 geometry of the Hamilton-Jacobi equation and generating functions (2017)",
    parameters: &[ParameterInfo {
        name: "order",
        summary: "the order m in h, even, 2 to 20: S_1, S_3, ..., S_(m-1)",
        default: ParameterDefault::Integer(2),
    }],
};

/// S_19 is the last coefficient that is formed.
const LARGEST_ORDER: i64 = 20;

struct Part;

impl DynamicsPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let order = parameters.get(&INFO, "order")?;
        if !(0..=LARGEST_ORDER).contains(&order) {
            return Err(BuildError::Parameter {
                part: INFO.name,
                parameter: "order".to_owned(),
                value: order.to_string(),
                expected: format!("the order m is even and lies in 2 to {LARGEST_ORDER}"),
            });
        }
        Ok(Arc::new(HamiltonJacobi::new(order as usize)?))
    }
}

leafwise_core::built_in!(Dynamics, Part);
