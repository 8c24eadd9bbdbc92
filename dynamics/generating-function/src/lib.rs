//! Dynamic approximations that a scene writes as the coefficients of a generating function.
//!
//! Ŝ_{ε,h} = Σ_{l odd} ε^{l−1} hˡ S_l gives the Lagrangian bisection graph(dŜ) (paper, section 4.2). S_1 = H in every
//! chart, and with the solution of the Hamilton–Jacobi equation up to S_{m−1} the map has order m. A scene gives S_1, S_3, …;
//! what it says of the order is a claim, which `leafwise verify` measures.

use std::sync::Arc;

use leafwise_core::formulas::{FormulaDynamics, FormulaText, scope};
use leafwise_core::part::{
    Dimensions, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters,
};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{
    BuildError, Correction, DynamicApproximation, DynamicsProperties, LagrangianBisection,
    PoissonSystem, RealizationData,
};
use leafwise_expression::Expression;

/// The part's name.
pub const NAME: &str = "generating-function";

static INFO: PartInfo = PartInfo {
    name: "generating-function",
    summary: "graph of dS, S = h S_1 + eps^2 h^3 S_3 + ... by coefficients that the scene writes",
    declares: "the order that the scene claims; self-adjoint; exactly Poisson over an exact realization",
    domain: "realizations with a cotangent chart; systems of single variables",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, section 4.2",
    parameters: &[
        ParameterInfo {
            name: COEFFICIENTS,
            summary: "S_1, S_3, ... at eps = 1: formulas of the variables, the system's parameters, and H for its Hamiltonian: \
                      [\"H\", \"x*y/24\"]",
            default: ParameterDefault::Formulas(&[HAMILTONIAN]),
        },
        ParameterInfo {
            name: ORDER,
            summary: "the order m in h that is claimed; 0 claims twice the number of coefficients",
            default: ParameterDefault::Integer(0),
        },
        ParameterInfo {
            name: TIME_STEP,
            summary: "the length of the only steps that S holds for, as of a table of many steps; steps of another length are refused; 0 takes all",
            default: ParameterDefault::Real(0.0),
        },
    ],
    is_written: true,
    ..PartInfo::of(PartKind::Dynamics)
};

const COEFFICIENTS: &str = "S";
const ORDER: &str = "order";

/// The parameter that says for which steps S holds.
pub const TIME_STEP: &str = "time-step";

/// Orders beyond this one are claims that no measurement in doubles tells apart.
const LARGEST_ORDER: i64 = 20;

/// The Hamiltonian's name in formulas, unless the system has one of this name.
const HAMILTONIAN: &str = "H";

/// The coefficients as text; which names they may use the system says.
#[derive(Clone, Debug)]
struct Written {
    text: String,
    order: usize,
    /// The length of the only steps that S holds for.
    time_step: Option<f64>,
}

impl Written {
    fn coefficients(&self) -> FormulaText<'_> {
        FormulaText {
            part: INFO.name,
            parameter: COEFFICIENTS,
            text: &self.text,
        }
    }

    /// The approximation with these coefficients.
    fn with(&self, coefficients: Vec<Expression>) -> FormulaDynamics {
        FormulaDynamics {
            name: INFO.name,
            order: self.order,
            self_adjoint: Some(true),
            correction: Correction::Bisection,
            dimensions: Dimensions {
                least: 1,
                most: None,
            },
            coefficients,
        }
    }
}

impl DynamicApproximation for Written {
    fn properties(&self) -> DynamicsProperties {
        DynamicsProperties {
            time_step: self.time_step,
            ..DynamicsProperties::of_order(self.order, Some(true))
        }
    }

    fn describe(&self) -> String {
        self.with(Vec::new()).describe()
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        let formulas = system.formulas(INFO.name)?;
        let mut scope = scope(INFO.name, system, &[])?;
        if !scope.has(HAMILTONIAN) {
            scope = scope.with_definition(HAMILTONIAN, formulas.hamiltonian().clone());
        }
        let coefficients = self.coefficients().parse(&scope)?;
        let own = self.with(coefficients);
        own.bisection(system, realization)
            .map_err(|error| match error {
                BuildError::Algebra(error) => BuildError::NotMade {
                    part: INFO.name,
                    reason: error.to_string(),
                },
                error => error,
            })
    }
}

fn build(parameters: &PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
    let text = parameters.setting(&INFO, COEFFICIENTS)?.to_string();
    let length = parameters.real(&INFO, TIME_STEP)?;
    if !(length.is_finite() && length >= 0.0) {
        return Err(BuildError::Parameter {
            part: INFO.name,
            parameter: TIME_STEP.to_owned(),
            value: length.to_string(),
            expected: "the length of a step, a positive number, or 0 for steps of all lengths"
                .to_owned(),
        });
    }
    let mut written = Written {
        text,
        order: 0,
        time_step: (length > 0.0).then_some(length),
    };
    let count = written.coefficients().len();
    if count == 0 {
        return Err(BuildError::NotMade {
            part: INFO.name,
            reason: format!("it needs `{COEFFICIENTS}`, the formulas of S_1, S_3, ..."),
        });
    }
    written.order = match parameters.get(&INFO, ORDER)? {
        0 => 2 * count,
        order @ 1..=LARGEST_ORDER => order.unsigned_abs() as usize,
        order => {
            return Err(BuildError::Parameter {
                part: INFO.name,
                parameter: ORDER.to_owned(),
                value: order.to_string(),
                expected: format!(
                    "1 to {LARGEST_ORDER}, or 0 for twice the number of coefficients"
                ),
            });
        }
    };
    Ok(Arc::new(written))
}

leafwise_core::built_in!(DynamicsPart::new(&INFO, build));
