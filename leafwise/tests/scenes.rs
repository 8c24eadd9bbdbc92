//! Scenes for the claims.

use leafwise::core::Registry;
use leafwise::scene::SceneDocument;

/// A system of the library from a state, with the paper's method for the rigid body.
pub fn scene(id: &str, initial: &str, time_step: f64, steps: u64) -> SceneDocument {
    let text = format!(
        "[system]\nlibrary = \"{id}\"\n[method]\n\
         realization = {{ name = \"karasev-truncated\", order = 6 }}\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\n\
         time-step = {time_step:?}\n[run]\ninitial = {initial}\nsteps = {steps}\n"
    );
    SceneDocument::parse(&format!("{id}.toml"), &text, &Registry::with_builtin()).expect("a scene")
}
