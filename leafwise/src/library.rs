//! Systems by name, as a scene's `library = "…"` asks for them.

use leafwise_core::part::PartKind;
use leafwise_core::registry::{Registry, SystemPart};
use leafwise_scene::SceneLibrary;

/// Where `library = "rigid-body"` is looked up: the systems of [`crate::systems`].
///
/// ```
/// use leafwise::prelude::*;
///
/// let scene = "[system]\nlibrary = \"rigid-body\"\n\
///              [method]\nrealization = \"auto\"\ndynamics = \"auto\"\ntime-step = 0.2\n\
///              [run]\ninitial = [1, 3, 3]\nsteps = 10\n";
/// let document = SceneDocument::parse("body.toml", scene, &ProblemLibrary).expect("a scene");
/// let run = compose(&document, &Registry::with_builtin()).expect("a run");
/// let mut integrator = run.integrator();
/// integrator.step().expect("a step");
/// assert_eq!(integrator.time(), 0.2);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ProblemLibrary;

impl SceneLibrary for ProblemLibrary {
    fn fragment(&self, id: &str) -> Option<&str> {
        leafwise_systems::find(id).map(|system| system.text)
    }

    fn ids(&self) -> Vec<&str> {
        leafwise_systems::all()
            .iter()
            .map(|system| system.id)
            .collect()
    }
}

/// The problem library, and the systems of a registry: those of plugins.
#[derive(Clone)]
pub struct SystemLibrary {
    parts: Vec<SystemPart>,
}

impl SystemLibrary {
    /// The library of a registry as it is now.
    pub fn of(registry: &Registry) -> Self {
        let parts = registry.parts().into_iter();
        let systems = parts.filter(|info| info.kind == PartKind::System);
        Self {
            parts: systems
                .filter_map(|info| registry.system(info.name).ok())
                .collect(),
        }
    }

    fn find(&self, id: &str) -> Option<&SystemPart> {
        self.parts.iter().find(|part| part.info.name == id)
    }
}

impl SceneLibrary for SystemLibrary {
    fn fragment(&self, id: &str) -> Option<&str> {
        match self.find(id) {
            Some(part) => part.fragment.as_deref(),
            None => ProblemLibrary.fragment(id),
        }
    }

    fn part(&self, id: &str) -> Option<&SystemPart> {
        self.find(id).filter(|part| part.has_numbers())
    }

    fn ids(&self) -> Vec<&str> {
        let own = self.parts.iter().map(|part| part.info.name);
        own.chain(ProblemLibrary.ids()).collect()
    }
}
