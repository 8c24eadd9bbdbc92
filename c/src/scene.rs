//! A scene, composed.

use std::path::Path;

use leafwise::core::Registry;
use leafwise::scene::compose::are_values;
use leafwise::scene::input::{LARGEST_SCENE, read_bounded};
use leafwise::scene::{ComposedRun, SceneChecks, SceneDocument, compose};
use leafwise_cli::arguments::PluginArguments;
use leafwise_cli::failure::Failure;
use leafwise_cli::plugins::Parts;
use leafwise_cli::scene::SceneText;

use crate::call_error::CallError;

/// Numbers of a scene.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafwiseShape {
    /// d, the number of coordinates.
    pub coordinates: usize,
    /// The number of parameters.
    pub parameters: usize,
    /// The number of Casimirs.
    pub casimirs: usize,
    /// The number of steps of its run.
    pub steps: u64,
    /// The time of a step.
    pub time_step: f64,
}

/// Kinds of names.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafwiseName {
    /// A coordinate.
    LEAFWISE_COORDINATE = 0,
    /// A parameter.
    LEAFWISE_PARAMETER = 1,
    /// A Casimir.
    LEAFWISE_CASIMIR = 2,
}

impl LeafwiseName {
    /// The kind with a number, `None` where there is none.
    pub(crate) fn of(number: u32) -> Option<Self> {
        match number {
            0 => Some(Self::LEAFWISE_COORDINATE),
            1 => Some(Self::LEAFWISE_PARAMETER),
            2 => Some(Self::LEAFWISE_CASIMIR),
            _ => None,
        }
    }
}

/// A scene with its method, shared by its integrators.
pub(crate) struct Scene {
    document: SceneDocument,
    registry: Registry,
    pub(crate) run: ComposedRun,
}

impl Scene {
    /// The scene in a file.
    pub(crate) fn read(file: &Path) -> Result<Self, CallError> {
        let bytes = read_bounded(file, LARGEST_SCENE);
        let bytes = bytes.map_err(|error| {
            CallError::usage(format!("cannot read {}: {error}", file.display()))
        })?;
        let text = String::from_utf8(bytes);
        let text =
            text.map_err(|_| CallError::usage(format!("{} is not UTF-8 text", file.display())))?;
        Self::parse(&file.display().to_string(), &text)
    }

    /// The scene of a text. Files that it names are beside its own.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Self, CallError> {
        // Trying a plugin starts this process's program anew, which is the caller's.
        let mut parts = Parts::new(&PluginArguments {
            no_plugins: true,
            ..PluginArguments::default()
        })?;
        let base = Path::new(name).parent().unwrap_or(Path::new("."));
        let text = SceneText {
            name: name.to_owned(),
            text: text.to_owned(),
            overrides: Vec::new(),
        };
        let document = parts.document(text, base)?;
        let run = compose(&document, &parts.registry)?;
        let scene = Self {
            document,
            registry: parts.registry,
            run,
        };
        scene.checked()
    }

    /// The same scene with a key at another value; the method is composed anew where it depends on it.
    pub(crate) fn with(&self, key: &str, value: &str) -> Result<Self, CallError> {
        let overrides = [(key.trim().to_owned(), value.trim().to_owned())];
        let (name, text) = (&self.document.name, &self.document.text);
        let document = SceneDocument::parse_with(name, text, &overrides, &self.registry);
        let document =
            document.map_err(|errors| CallError::from(Failure::Scene(errors.diagnostics())))?;
        let shared = match are_values(&overrides) {
            true => self.run.at(&document)?,
            false => None,
        };
        let is_known = shared.is_some();
        let run = match shared {
            Some(run) => run,
            None => compose(&document, &self.registry)?,
        };
        let scene = Self {
            document,
            registry: self.registry.clone(),
            run,
        };
        if is_known { Ok(scene) } else { scene.checked() }
    }

    /// Refuses a bracket that is not Poisson, and a Casimir that is none.
    fn checked(self) -> Result<Self, CallError> {
        let checks = SceneChecks::of(&self.run.system, &self.run.near).map_err(Failure::from)?;
        match checks.refusal(&self.document, (&self.run.system, &self.run.near), false) {
            Some(refusal) => Err(refusal.into()),
            None => Ok(self),
        }
    }

    /// The scene's text.
    pub(crate) fn text(&self) -> &str {
        &self.document.text
    }

    pub(crate) fn shape(&self) -> LeafwiseShape {
        LeafwiseShape {
            coordinates: self.run.plan.layout.coordinates(),
            parameters: self.run.system.parameters().len(),
            casimirs: self.run.system.casimir_names().len(),
            steps: self.run.plan.steps,
            time_step: self.run.plan.epsilon * self.run.plan.h,
        }
    }

    /// Names of a kind, in their order.
    pub(crate) fn names(&self, kind: LeafwiseName) -> Vec<String> {
        match kind {
            LeafwiseName::LEAFWISE_COORDINATE => self.run.names(),
            LeafwiseName::LEAFWISE_PARAMETER => {
                let parameters = self.run.system.parameters().iter();
                parameters.map(|parameter| parameter.name.clone()).collect()
            }
            LeafwiseName::LEAFWISE_CASIMIR => {
                let casimirs = self.run.system.casimir_names().into_iter();
                casimirs.map(str::to_owned).collect()
            }
        }
    }

    /// The same scene from another initial state.
    pub(crate) fn from(&self, initial: &[f64]) -> Result<Self, CallError> {
        if let Some(at) = initial.iter().position(|value| !value.is_finite()) {
            return Err(CallError::usage(format!(
                "the initial state has {} at place {at}, which is not a finite number",
                initial[at]
            )));
        }
        if self.run.method.lattice().is_some() {
            // Its states have no time or energy beside them, and its code is the same for all.
            let mut run = self.run.clone();
            run.plan.initial = self.run.whole(initial);
            return Ok(Self {
                document: self.document.clone(),
                registry: self.registry.clone(),
                run,
            });
        }
        self.with("run.initial", &format!("{initial:?}"))
    }
}
