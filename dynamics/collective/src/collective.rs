//! The dynamic approximation.

use std::sync::Arc;

use leafwise_core::part::{
    Compared, ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::runge_kutta::{PartitionedTableau, Tableau};
use leafwise_core::solver::check_equations;
use leafwise_core::{
    BuildError, ChartMaps, Correction, DynamicApproximation, DynamicsProperties, EndMaps,
    LagrangianBisection, PoissonSystem, RealizationData, RealizationMaps,
};

use crate::bisection::image_of_section;
use crate::gauss::gauss;
use crate::hamiltonian::collective_field;
use crate::implicit_midpoint::implicit_midpoint;
use crate::numbers::collective_numbers;
use crate::stormer_verlet::stormer_verlet;

static INFO: PartInfo = PartInfo {
    name: "collective",
    summary: "image of the section under a symplectic integrator of the collective Hamiltonian",
    declares: "order 2 (stormer-verlet, implicit-midpoint) or 2s (gauss); corrected: exactly \
               Poisson over an exact realization; uncorrected: Poisson to the integrator's order; \
               not self-adjoint, except the corrected implicit midpoint over some realizations",
    domain: "realizations with code or tangents, on T*M or with a symplectic chart, and coordinates with \
             a constant tensor; steps for which the stage equations converge",
    literature: "Cabrera, Martin de Diego, Vaquero, Approximating Symplectic Realizations, \
                 section 4.3 and Algorithm 2; McLachlan, Modin, Verdier, Collective symplectic \
                 integrators, Nonlinearity 27 (2014); Hairer, Lubich, Wanner, Geometric Numerical \
                 Integration, chapters II and VI",
    parameters: &[
        ParameterInfo {
            name: "integrator",
            summary: "the symplectic integrator: stormer-verlet, implicit-midpoint or gauss",
            default: ParameterDefault::Text("gauss"),
        },
        ParameterInfo {
            name: "stages",
            summary: "the stages of gauss, 1 to 16",
            default: ParameterDefault::Integer(2),
        },
        ParameterInfo {
            name: "correction",
            summary: "bisection: solve for the start of the integrator, so that the map is \
                      Poisson; none: start at the state itself, as in the paper",
            default: ParameterDefault::Text("bisection"),
        },
    ],
    serves_numbers: Some(ServesNumbers { rank: 2, limit: "" }),
    compared: Some(Compared {
        rank: 1,
        settings: &[
            &[("stages", ParameterDefault::Integer(2))],
            &[("stages", ParameterDefault::Integer(3))],
        ],
        over_lifts: &[
            &[("stages", ParameterDefault::Integer(2))],
            &[("stages", ParameterDefault::Integer(4))],
            &[("stages", ParameterDefault::Integer(8))],
            &[("stages", ParameterDefault::Integer(16))],
        ],
    }),
    surveyed: &[
        &[
            ("integrator", ParameterDefault::Text("stormer-verlet")),
            ("correction", ParameterDefault::Text("bisection")),
        ],
        &[
            ("integrator", ParameterDefault::Text("gauss")),
            ("stages", ParameterDefault::Integer(1)),
            ("correction", ParameterDefault::Text("bisection")),
        ],
        &[
            ("integrator", ParameterDefault::Text("gauss")),
            ("stages", ParameterDefault::Integer(2)),
            ("correction", ParameterDefault::Text("bisection")),
        ],
        &[
            ("integrator", ParameterDefault::Text("gauss")),
            ("stages", ParameterDefault::Integer(3)),
            ("correction", ParameterDefault::Text("bisection")),
        ],
        &[
            ("integrator", ParameterDefault::Text("stormer-verlet")),
            ("correction", ParameterDefault::Text("none")),
        ],
        &[
            ("integrator", ParameterDefault::Text("gauss")),
            ("stages", ParameterDefault::Integer(1)),
            ("correction", ParameterDefault::Text("none")),
        ],
        &[
            ("integrator", ParameterDefault::Text("gauss")),
            ("stages", ParameterDefault::Integer(2)),
            ("correction", ParameterDefault::Text("none")),
        ],
        &[
            ("integrator", ParameterDefault::Text("gauss")),
            ("stages", ParameterDefault::Integer(3)),
            ("correction", ParameterDefault::Text("none")),
        ],
    ],
    ..PartInfo::of(PartKind::Dynamics)
};

/// A symplectic integrator Σ_h on T*M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymplecticIntegrator {
    /// Order 2, partitioned.
    StormerVerlet,
    /// Order 2.
    ImplicitMidpoint,
    /// Order 2s with s stages.
    Gauss(usize),
}

impl SymplecticIntegrator {
    /// m.
    pub fn order(self) -> usize {
        match self {
            Self::StormerVerlet | Self::ImplicitMidpoint => 2,
            Self::Gauss(stages) => 2 * stages,
        }
    }

    /// The stages of the Gauss method for coordinates of any kind with a constant tensor; none of a partitioned integrator.
    fn of_lift(self) -> Option<usize> {
        match self {
            Self::StormerVerlet => None,
            Self::ImplicitMidpoint => Some(1),
            Self::Gauss(stages) => Some(stages),
        }
    }

    /// The coefficients for d positions and d momenta.
    pub fn tableau(self, dimension: usize) -> PartitionedTableau {
        match self {
            Self::StormerVerlet => stormer_verlet(dimension),
            Self::ImplicitMidpoint => implicit_midpoint(),
            Self::Gauss(stages) => gauss(stages),
        }
    }
}

impl std::fmt::Display for SymplecticIntegrator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::StormerVerlet => f.write_str("stormer-verlet"),
            Self::ImplicitMidpoint => f.write_str("implicit-midpoint"),
            Self::Gauss(stages) => write!(f, "gauss s = {stages}"),
        }
    }
}

/// A collective integrator (paper, Algorithm 2), corrected to a bisection or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collective {
    integrator: SymplecticIntegrator,
    correction: Correction,
}

impl Collective {
    /// The approximation by Σ_h; [`Correction::None`] is the paper's.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] for Gauss with 0 or more than sixteen stages.
    pub fn new(
        integrator: SymplecticIntegrator,
        correction: Correction,
    ) -> Result<Self, BuildError> {
        if let SymplecticIntegrator::Gauss(stages) = integrator
            && !(1..=Tableau::MOST_STAGES).contains(&stages)
        {
            return Err(stages_out_of_range(&stages.to_string()));
        }
        Ok(Self {
            integrator,
            correction,
        })
    }
}

impl DynamicApproximation for Collective {
    /// The adjoint is the image of σ(M) under the integrator of H∘β̂, in general another bisection.
    /// The corrected implicit midpoint rule is self-adjoint over realizations with p·α̂(x, p) = p·x: Karasev's and its
    /// truncations. There it is the Hamilton–Jacobi method of order 2. Over other realizations it is not known whether
    /// the rule is self-adjoint.
    ///
    /// A lift is served with the whole step by a Gauss method: a step that begins at x itself is the same there.
    fn properties(&self) -> DynamicsProperties {
        let midpoint = matches!(
            self.integrator,
            SymplecticIntegrator::ImplicitMidpoint | SymplecticIntegrator::Gauss(1)
        );
        let is_unknown = midpoint && self.correction == Correction::Bisection;
        let self_adjoint = (!is_unknown).then_some(false);
        DynamicsProperties {
            serves_lifts: true,
            correction: self.correction,
            ..DynamicsProperties::of_order(self.integrator.order(), self_adjoint)
        }
    }

    fn describe(&self) -> String {
        let correction = match self.correction {
            Correction::Bisection => "",
            Correction::None => ", uncorrected",
        };
        format!("{} {}{correction}", INFO.name, self.integrator)
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: self.describe(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        let abilities = realization.abilities();
        if abilities.lift.is_some() {
            let stages = self.integrator.of_lift();
            let stages = stages.ok_or_else(|| {
                missing(
                    "its coordinates are not positions and momenta; take gauss or implicit-midpoint",
                )
            })?;
            return Ok(LagrangianBisection::Lifted { stages });
        }
        let (d, parameters) = (system.dimension(), system.parameter_values());
        let chart = ChartMaps::of(realization.as_ref(), parameters.len())?.ok_or_else(|| {
            missing(
                "its points are not pairs (x, p) and it offers no symplectic chart about its \
                 section",
            )
        })?;
        let space = realization.space_dimension();
        let field = match (system.expressions(), abilities.ends) {
            (Some(formulas), Some(EndMaps::Code(code))) if abilities.space.has_code() => {
                collective_field(formulas, &code, abilities.space.chart_code().as_ref())?
            }
            _ => {
                let maps = RealizationMaps::new(realization.as_ref(), parameters.len())?;
                if !maps.has_jacobian() || !chart.has_jacobian() {
                    return Err(missing(
                        "it offers no tangents of its source map, which the gradient of the \
                         collective Hamiltonian needs",
                    ));
                }
                let gradient = system.gradient_map()?;
                let has_jacobian =
                    chart.has_pairs() && maps.has_hessian() && gradient.has_jacobian();
                collective_numbers(gradient, maps, chart.clone(), space, has_jacobian)
            }
        };
        let tableau = self.integrator.tableau(d);
        if field.has_jacobian() {
            check_equations(tableau.stages() * field.inputs())?;
        }
        let correction = self.correction;
        Ok(image_of_section(field, chart, tableau, correction, space))
    }
}

fn stages_out_of_range(value: &str) -> BuildError {
    BuildError::Parameter {
        part: INFO.name,
        parameter: "stages".to_owned(),
        value: value.to_owned(),
        expected: format!("the number of stages lies in 1 to {}", Tableau::MOST_STAGES),
    }
}

fn build(parameters: &PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
    let names = ["stormer-verlet", "implicit-midpoint", "gauss"];
    let stages = parameters.get(&INFO, "stages")?;
    let stages = usize::try_from(stages)
        .ok()
        .filter(|stages| (1..=Tableau::MOST_STAGES).contains(stages))
        .ok_or_else(|| stages_out_of_range(&stages.to_string()))?;
    let integrator = match parameters.word(&INFO, "integrator", &names)? {
        "stormer-verlet" => SymplecticIntegrator::StormerVerlet,
        "implicit-midpoint" => SymplecticIntegrator::ImplicitMidpoint,
        _ => SymplecticIntegrator::Gauss(stages),
    };
    let correction = match parameters.word(&INFO, "correction", &["bisection", "none"])? {
        "none" => Correction::None,
        _ => Correction::Bisection,
    };
    Ok(Arc::new(Collective::new(integrator, correction)?))
}

leafwise_core::built_in!(DynamicsPart::new(&INFO, build));
