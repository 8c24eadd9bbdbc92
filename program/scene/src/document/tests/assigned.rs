//! What is assigned is what the reader reads from the rewritten text.

use leafwise_core::Registry;

use crate::document::SceneDocument;

const FACTORS: &str = r#"
[system]
variables   = ["q", "p"]
parameters  = { a = 1, b = 2.5 }
bracket     = { "q,p" = "1" }
hamiltonian = "a*p^2/2 + b*q^2/2"
[method]
realization = "auto"
dynamics    = "auto"
epsilon     = 0.1
h           = 2
[run]
initial = { q = "a", p = 0 }
steps   = 10
"#;

/// The same without places, which an assigned value has of the text before.
fn values(document: &SceneDocument) -> String {
    let parameters = document.system.parameters.iter();
    let parameters: Vec<_> = parameters
        .map(|(name, value)| (&name.value, &value.value))
        .collect();
    let step = &document.method.step;
    let composed = crate::compose::compose(document, &Registry::with_builtin()).expect("a run");
    format!(
        "{parameters:?} {} {} {} {:?}",
        step.epsilon(),
        step.h(),
        document.run.steps.value,
        composed.plan.initial
    )
}

#[test]
fn an_assigned_value_is_the_one_that_is_read() {
    let registry = Registry::with_builtin();
    for (key, value) in [
        ("system.parameters.a", "0.3"),
        ("system.parameters.b", "7"),
        ("system.parameters.b", "1_000.5"),
        ("method.time-step", "0.25"),
        ("method.epsilon", "1e-3"),
        ("method.h", "-2"),
        ("run.steps", "17"),
        ("run.initial", "[0.5, -1]"),
        ("run.initial.q", "0.75"),
    ] {
        let mut assigned = SceneDocument::parse("case", FACTORS, &registry).expect("a scene");
        assert!(assigned.assign(key, value), "{key} = {value}");
        let set = [(key.to_owned(), value.to_owned())];
        let read = SceneDocument::parse_with("case", FACTORS, &set, &registry).expect("a scene");
        assert_eq!(values(&assigned), values(&read), "{key} = {value}");
        // A composed run at other values is the run composed of them.
        let before = SceneDocument::parse("case", FACTORS, &registry).expect("a scene");
        let run = crate::compose::compose(&before, &registry).expect("a run");
        let at = run
            .at(&assigned)
            .expect("a state")
            .expect("a run of values");
        let composed = crate::compose::compose(&read, &registry).expect("a run");
        assert_eq!(at.plan.initial, composed.plan.initial);
        assert_eq!(
            [at.plan.epsilon, at.plan.h],
            [composed.plan.epsilon, composed.plan.h]
        );
        assert_eq!(at.plan.steps, composed.plan.steps);
        assert_eq!(
            at.system.parameter_values(),
            composed.system.parameter_values()
        );
    }
}

#[test]
fn what_the_reader_has_to_judge_is_left_to_it() {
    let registry = Registry::with_builtin();
    let scene = SceneDocument::parse("case", FACTORS, &registry).expect("a scene");
    for (key, value) in [
        ("system.parameters.c", "1"),
        ("system.parameters.a", "nan"),
        ("system.parameters.a", "one"),
        ("system.parameters.a", ".5"),
        ("method.time-step", "0"),
        ("method.epsilon", "1e308"),
        ("method.realization.order", "4"),
        ("run.steps", "-1"),
        ("run.steps", "2.5"),
        ("run.until", "1"),
        ("run.initial", "[1]"),
        ("run.initial", "[1, nan]"),
        ("run.initial.x", "1"),
        ("run.initial.q", "[1]"),
    ] {
        let mut assigned = scene.clone();
        assert!(!assigned.assign(key, value), "{key} = {value}");
        assert_eq!(assigned, scene, "{key} = {value}");
    }
}
