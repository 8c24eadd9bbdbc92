//! A system with a state to start from and a flow to compare with.

use std::fmt;
use std::sync::Arc;

use leafwise_core::diagnostics::MOST_MEASURED;
use leafwise_core::part::Family;
use leafwise_core::{BuildError, PoissonSystem, Registry, StepError, StepMap, Walk};
use leafwise_scene::compose::{Stepping, refuse_noise};
use leafwise_scene::{Refusal, SceneDocument, compose, compose_system};

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
    /// The scene's own method, where it is to be measured beside the others.
    pub own: Option<Own>,
}

/// A scene's own method.
#[derive(Clone)]
pub struct Own {
    /// Its steps.
    pub map: Arc<dyn StepMap>,
    /// The length of the only steps that it makes, as a table of many steps.
    pub only_step: Option<f64>,
}

impl fmt::Debug for Own {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.map.describe())
    }
}

/// Steps of the reference flow: an implicit method of high order on the equations themselves, neither a
/// realization nor a bisection.
const REFERENCE_STEPS: u32 = 128;

impl Problem {
    /// The problem of a scene, at its initial state and step.
    ///
    /// # Errors
    /// [`ProblemError::Refused`] with the scene's first error.
    pub fn of_scene(document: &SceneDocument) -> Result<Self, ProblemError> {
        let composed = compose_system(document).map_err(ProblemError::Refused)?;
        Ok(Self::of(document, composed.system, composed.near))
    }

    /// The same with the scene's own method, composition and all. On a lattice it stays without: the sweeps are no map
    /// of the coordinates that are measured here. Sums over pairs that are taken in loops stay so: what needs them written out
    /// does not fit.
    ///
    /// # Errors
    /// [`ProblemError::Refused`] where the scene or its method does not fit.
    pub fn with_method(
        document: &SceneDocument,
        registry: &Registry,
    ) -> Result<Self, ProblemError> {
        refuse_noise(
            document,
            "methods are not measured on the motion",
            "measure them on a copy of the scene without noise",
        )
        .map_err(ProblemError::Refused)?;
        let run = compose(document, registry).map_err(ProblemError::Refused)?;
        let only_step = run.table_step();
        let mut problem = match run.system.opaque() {
            Some(_) => Self::of(document, run.system, run.near),
            None => Self::of_scene(document)?,
        };
        let own = |map| Some(Own { map, only_step });
        // The flow and the tensor are those of the homogeneous system of a contact bracket, and so is the map.
        problem.own = match (run.homogeneous, run.method) {
            (Some(map), _) => own(map),
            (None, Stepping::Written(method)) => own(Arc::new(*method)),
            (None, Stepping::Map(stepping)) => own(stepping.map),
            (None, Stepping::Lattice(_)) => None,
        };
        Ok(problem)
    }

    /// A system from this state, at the step of a scene.
    fn of(document: &SceneDocument, system: PoissonSystem, initial: Vec<f64>) -> Self {
        let step = &document.method.step;
        Self {
            name: document
                .fragment
                .as_ref()
                .map_or_else(|| document.name.clone(), |(id, _)| id.clone()),
            system,
            initial,
            time_step: step.epsilon() * step.h(),
            own: None,
        }
    }

    /// A system of the library at its default state and step.
    ///
    /// # Errors
    /// [`ProblemError::UnknownSystem`]; the others are defects of the library.
    pub fn of_library(id: &str) -> Result<Self, ProblemError> {
        let unknown = || ProblemError::UnknownSystem { id: id.to_owned() };
        let entry = leafwise_systems::find(id).ok_or_else(unknown)?;
        let defaults = entry.defaults()?;
        let initial = &defaults.initial;
        let text = format!(
            "[system]\nlibrary = \"{id}\"\n[method]\ntime-step = {:?}\n[run]\ninitial = {initial}\n\
             steps = 1\n",
            defaults.time_step
        );
        let document = SceneDocument::parse(id, &text, &Registry::with_builtin())?;
        Self::of_scene(&document)
    }

    /// Whether tensor defects are measured along a few random directions: all entries of many coordinates take too long.
    pub fn is_sampled(&self) -> bool {
        self.system.dimension() > MOST_MEASURED
    }

    /// The order that seams and tables of the formulas may reduce a step to; `None` where every formula is smooth.
    pub fn smooth_order(&self) -> Option<usize> {
        self.system.expressions()?.smooth_order()
    }

    /// The state after time `t`, by a method of another family with a small step.
    ///
    /// # Errors
    /// [`BuildError`] when the reference stepper is not registered, its [`StepError`] as text.
    pub fn flow(&self, registry: &Registry, t: f64) -> Result<Vec<f64>, FlowError> {
        let (reference, given) = registry.reference(Family::Implicit)?;
        let map = reference.build(&self.system, &given)?;
        let values = self.system.parameter_values();
        let step = t / f64::from(REFERENCE_STEPS);
        let mut walk = Walk::new(map.as_ref(), &values, 1.0, step, &self.initial);
        walk.advance(u64::from(REFERENCE_STEPS))?;
        Ok(walk.state().to_vec())
    }
}

/// Why a problem could not be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// The library has no system of this name.
    #[error("the library has no system `{id}`")]
    UnknownSystem {
        /// The name.
        id: String,
    },
    /// The library's entry cannot be read.
    #[error("{0}")]
    Library(#[from] leafwise_systems::SystemError),
    /// The scene cannot be read.
    #[error("{0}")]
    Scene(#[from] leafwise_scene::SceneErrors),
    /// The scene's system cannot be built.
    #[error("{0}")]
    Refused(Refusal),
}

/// Why a reference flow could not be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlowError {
    /// The reference stepper could not be built.
    #[error("the reference stepper: {0}")]
    Build(#[from] BuildError),
    /// A step of it failed.
    #[error("the reference flow: {0}")]
    Step(#[from] StepError),
}
