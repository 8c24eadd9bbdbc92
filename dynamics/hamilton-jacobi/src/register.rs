//! The part `hamilton-jacobi`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{BuildError, DynamicApproximation};

use crate::bisection::{HamiltonJacobi, Hamiltonian};

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
    parameters: &[
        ParameterInfo {
            name: "order",
            summary: "the order m in h, even, 2 to 20: S_1, S_3, ..., S_(m-1)",
            default: ParameterDefault::Integer(2),
        },
        ParameterInfo {
            name: HAMILTONIAN,
            summary: "\"given\": H; \"energy-casimir\": H less the multiples of Casimirs that leave \
                      the smallest coefficients, the same motion with a shorter series",
            default: ParameterDefault::Text(GIVEN),
        },
    ],
};

const HAMILTONIAN: &str = "hamiltonian";
const GIVEN: &str = "given";
const ENERGY_CASIMIR: &str = "energy-casimir";

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
        let hamiltonian = match parameters.word(&INFO, HAMILTONIAN, &[GIVEN, ENERGY_CASIMIR])? {
            ENERGY_CASIMIR => Hamiltonian::EnergyCasimir,
            _ => Hamiltonian::Given,
        };
        Ok(Arc::new(
            HamiltonJacobi::new(order as usize)?.of(hamiltonian),
        ))
    }
}

leafwise_core::built_in!(Dynamics, Part);
