//! The dynamic approximation.

use std::sync::Arc;

use leafwise_core::runge_kutta::PartitionedTableau;
use leafwise_core::{
    BuildError, ChartMaps, Correction, DynamicApproximation, LagrangianBisection, PoissonSystem,
    RealizationData, RealizationMaps,
};

use crate::bisection::ImageOfSection;
use crate::gauss::{MOST_STAGES, gauss};
use crate::hamiltonian::collective_field;
use crate::implicit_midpoint::implicit_midpoint;
use crate::numbers::collective_numbers;
use crate::stormer_verlet::stormer_verlet;

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
    /// [`BuildError::Parameter`] for Gauss with 0 or more than eight stages.
    pub fn new(
        integrator: SymplecticIntegrator,
        correction: Correction,
    ) -> Result<Self, BuildError> {
        if let SymplecticIntegrator::Gauss(stages) = integrator
            && !(1..=MOST_STAGES).contains(&stages)
        {
            return Err(crate::register::stages_out_of_range(&stages.to_string()));
        }
        Ok(Self {
            integrator,
            correction,
        })
    }
}

impl DynamicApproximation for Collective {
    fn order(&self) -> usize {
        self.integrator.order()
    }

    /// The adjoint is the image of σ(M) under the integrator of H∘β̂, in general another bisection.
    /// The corrected implicit midpoint rule is self-adjoint over realizations with p·α̂(x, p) = p·x,
    /// Karasev's and its truncations, where it is the Hamilton–Jacobi method of order 2; over others
    /// that is not known.
    fn self_adjoint(&self) -> Option<bool> {
        let midpoint = matches!(
            self.integrator,
            SymplecticIntegrator::ImplicitMidpoint | SymplecticIntegrator::Gauss(1)
        );
        if midpoint && self.correction == Correction::Bisection {
            None
        } else {
            Some(false)
        }
    }

    fn correction(&self) -> Correction {
        self.correction
    }

    fn describe(&self) -> String {
        let correction = match self.correction {
            Correction::Bisection => "",
            Correction::None => ", uncorrected",
        };
        format!(
            "{} {}{correction}",
            crate::register::INFO.name,
            self.integrator
        )
    }

    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<Arc<dyn LagrangianBisection>, BuildError> {
        let missing = |reason: &str| BuildError::Incompatible {
            dynamics: self.describe(),
            realization: realization.describe(),
            reason: reason.to_owned(),
        };
        let (d, parameters) = (system.dimension(), system.parameter_values());
        let chart = ChartMaps::of(realization, parameters.len())?.ok_or_else(|| {
            missing(
                "its points are not pairs (x, p) and it offers no symplectic chart about its \
                 section",
            )
        })?;
        let space = realization.space_dimension();
        let chart_has_code = chart.has_pairs() || realization.chart().is_some();
        let code = realization.code().filter(|_| chart_has_code);
        let field = match (system.expressions(), code) {
            (Some(formulas), Some(code)) => collective_field(formulas, code, realization.chart())?,
            _ => {
                let maps = RealizationMaps::new(realization, &parameters)?;
                let worker = maps.worker(&parameters, 1.0);
                if !worker.has_tangents() || !chart.worker(&parameters, 1.0).has_tangent() {
                    return Err(missing(
                        "it offers no tangents of its source map, which the gradient of the \
                         collective Hamiltonian needs",
                    ));
                }
                let gradient = system.gradient_map()?;
                let has_jacobian =
                    chart.has_pairs() && worker.has_source_hessian() && gradient.has_jacobian();
                collective_numbers(gradient, maps, chart.clone(), space, has_jacobian)
            }
        };
        Ok(Arc::new(ImageOfSection::new(
            field,
            chart,
            self.integrator.tableau(d),
            self.correction,
            space,
        )))
    }
}
