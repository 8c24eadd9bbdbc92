//! A system with a state to start from and a flow to compare with.

use leafwise_core::{BuildError, Integrator, PartParameters, PoissonSystem, Registry, StepError};
use leafwise_scene::{SceneDocument, compose_system};

use crate::library::ProblemLibrary;

/// A problem that step maps are measured on.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its name.
    pub name: String,
    /// (M, π, H).
    pub system: PoissonSystem,
    /// x_0.
    pub initial: Vec<f64>,
    /// A step at which methods are compared.
    pub time_step: f64,
}

/// Steps and stages of the reference flow: Gauss of order 16 on the equations themselves, neither
/// a realization nor a bisection.
const REFERENCE_STEPS: u32 = 128;
const REFERENCE_STAGES: i64 = 8;

impl Problem {
    /// The problem of a scene, at its initial state and step.
    ///
    /// # Errors
    /// The scene's first error, as text.
    pub fn of_scene(document: &SceneDocument) -> Result<Self, String> {
        let composed = compose_system(document).map_err(|refusal| refusal.to_string())?;
        let step = &document.method.step;
        Ok(Self {
            name: document
                .fragment
                .as_ref()
                .map_or_else(|| document.name.clone(), |(id, _)| id.clone()),
            system: composed.system,
            initial: composed.near,
            time_step: step.epsilon() * step.h(),
        })
    }

    /// A system of the library at its default state and step.
    ///
    /// # Errors
    /// What is wrong with the library's entry, as text.
    pub fn of_library(id: &str) -> Result<Self, String> {
        let entry = leafwise_systems::find(id).ok_or_else(|| format!("no system `{id}`"))?;
        let defaults = entry.defaults().map_err(|error| error.to_string())?;
        let initial = &defaults.initial;
        let text = format!(
            "[system]\nlibrary = \"{id}\"\n[method]\ntime-step = {:?}\n[run]\ninitial = {initial}\n\
             steps = 1\n",
            defaults.time_step
        );
        let document = SceneDocument::parse(id, &text, &ProblemLibrary)
            .map_err(|errors| errors.to_string())?;
        Self::of_scene(&document)
    }

    /// The state after time `t`, by a method of another family with a small step.
    ///
    /// # Errors
    /// [`BuildError`] when the reference stepper is not registered, its [`StepError`] as text.
    pub fn flow(&self, registry: &Registry, t: f64) -> Result<Vec<f64>, FlowError> {
        let parameters = PartParameters::new().with("stages", REFERENCE_STAGES);
        let map = registry
            .stepper("gauss")?
            .build(&self.system, &parameters)?;
        let values = self.system.parameter_values();
        let step = t / f64::from(REFERENCE_STEPS);
        let mut integrator = Integrator::new(map.as_ref(), &values, 1.0, step, &self.initial);
        for _ in 0..REFERENCE_STEPS {
            integrator.step()?;
        }
        Ok(integrator.state().to_vec())
    }
}

/// Why a reference flow could not be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// The reference stepper could not be built.
    #[error("the reference stepper: {0}")]
    Build(#[from] BuildError),
    /// A step of it failed.
    #[error("the reference flow: {0}")]
    Step(#[from] StepError),
}
