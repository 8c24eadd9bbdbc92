//! A scene that asks for more than it uses, or for less than it needs, is told so, with the line to
//! write instead; that line mends it. Scenes that deserve no warning get none.

mod cheaper;
mod realizations;
mod round_off;
mod scenes;
mod steppers;
mod steps;

use leafwise::prelude::*;
use leafwise::run::advice::{
    Advice, AdviceKind, JudgedStates, about_the_scene, advise, states_ahead,
};
use leafwise::run::{Asked, Quiet, run_in_memory};
use leafwise_tests::scenes::{composed, document};

/// A system of the library from a state, with a method.
fn scene(library: &str, initial: &str, method: &str) -> String {
    format!(
        "[system]\nlibrary = \"{library}\"\n[method]\n{method}\n[run]\ninitial = {initial}\n\
         steps = 1000\n"
    )
}

fn body(method: &str) -> String {
    scene("rigid-body", "[1, 3, 3]", method)
}

fn advice(text: &str) -> Vec<Advice> {
    let run = composed(text);
    advise(
        &run,
        &Registry::with_builtin(),
        (&states_ahead(&run), JudgedStates::Ahead),
    )
}

fn of_kind(text: &str, kind: AdviceKind) -> Option<Advice> {
    advice(text).into_iter().find(|advice| advice.kind == kind)
}

/// The scene with the line of `[method]` that a warning says.
fn changed(text: &str, advice: &Advice) -> String {
    let line = |line: &str| {
        let (key, value) = line.split_once(" = ").expect("a line");
        (format!("method.{key}"), value.to_owned())
    };
    let overrides: Vec<_> = advice.change.lines().map(line).collect();
    let changed = SceneDocument::parse_with("scene", text, &overrides, &Registry::with_builtin());
    changed.expect("a scene").text
}

/// x after some steps.
fn end(text: &str, steps: usize) -> Vec<f64> {
    let run = composed(text);
    let mut walk = run.walk();
    (0..steps).for_each(|_| walk.step().expect("a step"));
    walk.state().to_vec()
}

#[test]
fn the_scenes_of_the_gallery_deserve_no_warning() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    for entry in std::fs::read_dir(folder).expect("the gallery") {
        let path = entry.expect("an entry").path();
        // Folders hold the files that scenes name.
        if path.is_dir() {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a scene");
        let (name, registry) = (path.display().to_string(), Registry::with_builtin());
        let document = SceneDocument::parse(&name, &text, &registry).expect("a scene");
        let run = compose(&document, &registry).expect("a run");
        assert_eq!(
            advise(&run, &registry, (&states_ahead(&run), JudgedStates::Ahead)),
            [],
            "{name}"
        );
        assert_eq!(about_the_scene(&document, &run), [], "{name}");
    }
}

/// What a whole run in memory tells.
fn told(text: &str) -> Vec<Advice> {
    let registry = Registry::with_builtin();
    let (document, run) = (document(text, &[]), composed(text));
    let recorded = run_in_memory(&document, &run, &registry, Asked::default(), &mut Quiet);
    recorded.expect("a run").report.advice
}

fn told_of_kind(text: &str, kind: AdviceKind) -> Option<Advice> {
    told(text).into_iter().find(|advice| advice.kind == kind)
}

/// All coordinates at the end of the scene's steps.
fn scene_end(text: &str) -> Vec<f64> {
    leafwise_tests::scenes::end(&composed(text))
}
