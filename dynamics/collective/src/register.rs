//! The part `collective`.

use std::sync::Arc;

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::DynamicsPart;
use leafwise_core::{BuildError, Correction, DynamicApproximation};

use crate::collective::{Collective, SymplecticIntegrator};
use crate::gauss::MOST_STAGES;

pub(crate) static INFO: PartInfo = PartInfo {
    name: "collective",
    kind: PartKind::Dynamics,
    summary: "image of the section under a symplectic integrator of the collective Hamiltonian",
    declares: "order 2 (stormer-verlet, implicit-midpoint) or 2s (gauss); corrected: exactly \
               Poisson over an exact realization; uncorrected: Poisson to the integrator's order; \
               not self-adjoint, except the corrected implicit midpoint over some realizations",
    domain: "realizations with code or tangents, on T*M or with a symplectic chart; steps for which \
             the stage equations converge",
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
            summary: "the stages of gauss, 1 to 8",
            default: ParameterDefault::Integer(2),
        },
        ParameterInfo {
            name: "correction",
            summary: "bisection: solve for the start of the integrator, so that the map is \
                      Poisson; none: start at the state itself, as in the paper",
            default: ParameterDefault::Text("bisection"),
        },
    ],
};

pub(crate) fn stages_out_of_range(value: &str) -> BuildError {
    BuildError::Parameter {
        part: INFO.name,
        parameter: "stages".to_owned(),
        value: value.to_owned(),
        expected: format!("the number of stages lies in 1 to {MOST_STAGES}"),
    }
}

struct Part;

impl DynamicsPart for Part {
    fn info(&self) -> &'static PartInfo {
        &INFO
    }

    fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        let names = ["stormer-verlet", "implicit-midpoint", "gauss"];
        let stages = parameters.get(&INFO, "stages")?;
        let stages = usize::try_from(stages)
            .ok()
            .filter(|stages| (1..=MOST_STAGES).contains(stages))
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
}

leafwise_core::built_in!(Dynamics, Part);
