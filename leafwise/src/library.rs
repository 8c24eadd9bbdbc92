//! The problem library as a scene's source of systems.

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
