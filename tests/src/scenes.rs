//! Runs composed from scene texts.

use leafwise_core::Registry;
use leafwise_scene::{ComposedRun, SceneDocument, compose};

/// The document of a text, with the values of these keys changed.
///
/// # Panics
/// With the errors and the text.
pub fn document(text: &str, overrides: &[(&str, &str)]) -> SceneDocument {
    let overrides: Vec<(String, String)> = overrides
        .iter()
        .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
        .collect();
    SceneDocument::parse_with("scene", text, &overrides, &Registry::with_builtin())
        .unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

/// The run of a text.
///
/// # Panics
/// With the refusal and the text.
pub fn composed(text: &str) -> ComposedRun {
    compose(&document(text, &[]), &Registry::with_builtin())
        .unwrap_or_else(|refusal| panic!("{refusal}\n{text}"))
}

/// The run of a `[system]` and a `[method]` from an initial state, to t = `time` in so many steps.
///
/// # Panics
/// With the refusal and the text.
pub fn until(
    system: &str,
    method: &str,
    initial: &str,
    (time, steps): (f64, usize),
) -> ComposedRun {
    let step = time / steps as f64;
    composed(&format!(
        "[system]\n{system}\n[method]\n{method}\ntime-step = {step:?}\n[run]\ninitial = {initial}\nsteps = {steps}\n"
    ))
}

/// The scene's own coordinates at the end of its steps.
///
/// # Panics
/// When a step is refused.
pub fn end(run: &ComposedRun) -> Vec<f64> {
    let mut walk = run.walk();
    walk.advance(run.plan.steps).expect("every step");
    run.own(walk.state()).to_vec()
}
