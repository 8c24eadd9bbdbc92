//! graph(dŜ) as a Lagrangian bisection.

use std::sync::Arc;

use leafwise_core::part::{
    Auto, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{
    BuildError, DynamicApproximation, DynamicsProperties, LagrangianBisection, OneForm,
    PoissonSystem, RealizationData,
};

use crate::coefficients::NAME;
use crate::coefficients::first_order;
use crate::form::shortest;
use crate::numbers::differential;

static INFO: PartInfo = PartInfo {
    name: NAME,
    summary: "graph of dS, S the truncated solution of the Hamilton-Jacobi equation",
    declares: "order m (even); self-adjoint; exactly Poisson over an exact realization",
    domain: "realizations with a cotangent chart; Hamiltonians that formulas can express, of order 2 \
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
    auto: Some(Auto::OfOrder),
    serves_numbers: Some(ServesNumbers {
        rank: 1,
        limit: "of order 2",
    }),
    surveyed: &[
        &[("order", ParameterDefault::Integer(2))],
        &[("order", ParameterDefault::Integer(4))],
        &[("order", ParameterDefault::Integer(6))],
        &[("order", ParameterDefault::Integer(8))],
    ],
    ..PartInfo::of(PartKind::Dynamics)
};

const HAMILTONIAN: &str = "hamiltonian";
const GIVEN: &str = "given";
const ENERGY_CASIMIR: &str = "energy-casimir";

/// S_19 is the last coefficient that is formed.
const LARGEST_ORDER: i64 = 20;

/// The Hamilton–Jacobi approximation of even order m (paper, section 4.2 and Algorithm 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HamiltonJacobi {
    order: usize,
    hamiltonian: Hamiltonian,
}

/// Which function of the motion the series is made from. Both generate the same motion; the maps that
/// approximate it differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hamiltonian {
    /// H as the system gives it.
    #[default]
    Given,
    /// [`SystemFormulas::energy_casimir`](leafwise_core::SystemFormulas::energy_casimir): H less the
    /// multiples of Casimirs that leave the smallest coefficients; refused where none does.
    EnergyCasimir,
}

impl HamiltonJacobi {
    /// Order m, even and at least 2.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] for an odd order, with both neighbours named, and for 0.
    pub fn new(order: usize) -> Result<Self, BuildError> {
        if order == 0 || order % 2 == 1 {
            let expected = match order {
                0 | 1 => "the order m is even and at least 2".to_owned(),
                odd => format!(
                    "the order m is even, since even coefficients of S vanish: take {} or {}",
                    odd - 1,
                    odd + 1
                ),
            };
            return Err(BuildError::Parameter {
                part: INFO.name,
                parameter: "order".to_owned(),
                value: order.to_string(),
                expected,
            });
        }
        Ok(Self {
            order,
            hamiltonian: Hamiltonian::Given,
        })
    }

    /// The same made from another function of the same motion.
    pub fn of(self, hamiltonian: Hamiltonian) -> Self {
        Self {
            hamiltonian,
            ..self
        }
    }

    /// The system whose Hamiltonian is expanded, `None` where it is the given one.
    fn less_casimirs(&self, system: &PoissonSystem) -> Result<Option<PoissonSystem>, BuildError> {
        if self.hamiltonian == Hamiltonian::Given {
            return Ok(None);
        }
        let formulas = system.formulas(INFO.name)?;
        let shorter = formulas.energy_casimir()?;
        let shorter = shorter.ok_or_else(|| BuildError::DoesNotFit {
            part: INFO.name,
            reason:
                "no multiple of its Casimirs leaves a Hamiltonian with smaller coefficients: take \
                     hamiltonian = \"given\""
                    .to_owned(),
        })?;
        Ok(Some(formulas.with_hamiltonian(shorter)?.into()))
    }
}

impl DynamicApproximation for HamiltonJacobi {
    /// S is odd in h (paper, Proposition 1), so the map is its own adjoint.
    fn properties(&self) -> DynamicsProperties {
        DynamicsProperties::of_order(self.order, Some(true))
    }

    fn describe(&self) -> String {
        let of = match self.hamiltonian {
            Hamiltonian::Given => "",
            Hamiltonian::EnergyCasimir => " of an energy-Casimir function",
        };
        format!("{} m = {}{of}", INFO.name, self.order)
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        let less = self.less_casimirs(system)?;
        let system = less.as_ref().unwrap_or(system);
        let graph = |form| {
            let parameters = system.parameters().len();
            LagrangianBisection::odd_graph(form, realization, parameters, &self.describe())
        };
        if let Some(opaque) = system.opaque() {
            if self.order > 2 {
                let missing = "formulas of the system for an order above 2";
                return Err(opaque.not_offered(INFO.name, missing));
            }
            return graph(OneForm::Numbers(differential(system)?));
        }
        let generating = match realization.abilities().series {
            Some(series) => shortest(system, &series, self.order)?,
            None if self.order == 2 => first_order(system)?,
            None => {
                return Err(BuildError::Incompatible {
                    dynamics: self.describe(),
                    realization: realization.describe(),
                    reason: "it offers no series of its source map; order 2, with S = h H alone, \
                             needs none"
                        .to_owned(),
                });
            }
        };
        graph(OneForm::Differential(generating))
    }
}

fn build(parameters: &PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
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

leafwise_core::built_in!(DynamicsPart::new(&INFO, build));
