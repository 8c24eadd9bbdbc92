//! Initial states, steps and ends by formulas.

use std::f64::consts::PI;

use leafwise_core::Registry;

use super::{compose_system, document, refusal};
use crate::document::{SceneDocument, SceneErrors};

const PLANE: &str = "variables = [\"q\", \"p\"]\nparameters = { start = 0.3 }\nbracket = \"canonical\"\n\
                     convention = \"{x,H}\"\nhamiltonian = \"p^2/2 - cos(q)\"";

fn document_of(system: &str, run: &str) -> Result<SceneDocument, SceneErrors> {
    let text = format!("[system]\n{system}\n[method]\ntime-step = 0.1\n[run]\nsteps = 1\n{run}\n");
    SceneDocument::parse("scene.toml", &text, &Registry::empty())
}

/// Of a list the entries are the variables' in their order, numbers and formulas alike.
#[test]
fn formulas_and_numbers_stand_in_one_list() {
    for (list, expected) in [
        ("[1, 2]", [1.0, 2.0]),
        ("[\"pi/3\", 0]", [PI / 3.0, 0.0]),
        ("[0.5, \"sqrt(2)/4\"]", [0.5, libm::sqrt(2.0) / 4.0]),
        ("[\"start\", \"-2*start\"]", [0.3, -0.6]),
        ("[\"start + pi/2\", 1]", [0.3 + PI / 2.0, 1.0]),
    ] {
        let run = format!("initial = {list}");
        let composed = compose_system(&document(PLANE, &run)).expect("a system");
        assert_eq!(composed.initial, expected, "{list}");
    }
}

/// `r.x = 1` without quotes is a table in TOML.
#[test]
fn components_of_vectors_need_no_quotes() {
    let system = "variables = { r = 3, v = 3 }\nbracket = { canonical = [[\"r\", \"v\"]] }\n\
                  hamiltonian = \"dot(v, v)/2\"";
    let expected = [1.0, 0.0, -0.5, 0.0, 2.0, 3.0];
    for run in [
        "initial = { r.x = 1, r.y = 0, r.z = \"-1/2\", v = [0, 2, 3] }",
        "initial = { \"r.x\" = 1, \"r.y\" = 0, r.z = -0.5, v.x = 0, v.y = 2, v.z = 3 }",
    ] {
        let composed = compose_system(&document(system, run)).expect("a system");
        assert_eq!(composed.initial, expected, "{run}");
    }
    let twice = document_of(
        system,
        "initial = { r.x = 1, \"r.x\" = 2, r.y = 0, r.z = 0, v = [0, 2, 3] }",
    );
    assert!(twice.is_err());
}

/// What is wrong in one is underlined there.
#[test]
fn a_wrong_entry_is_underlined() {
    let diagnostic = refusal(PLANE, "initial = [\"stort\", 0]");
    assert_eq!(&diagnostic.source_text[diagnostic.span.clone()], "stort");
    for (run, message) in [
        (
            "initial = [\"pi\"]",
            "initial has 1 entries, expected 2, one for each variable",
        ),
        ("initial = [\"pi\", \"start\", 0]", "unknown name `start`"),
        ("initial = [\"1/0\", 0]", "`initial[0]`"),
    ] {
        let errors = document_of(PLANE, run).expect_err(run);
        let told = &errors.diagnostics()[0].message;
        assert!(told.contains(message), "{run}: {told}");
    }
}

#[test]
fn steps_and_ends_are_formulas_of_numbers() {
    let scene = |step: &str| {
        let text = format!(
            "[system]\n{PLANE}\n[method]\n{step}\n[run]\ninitial = [1, 0]\nuntil = \"4*pi\"\n"
        );
        SceneDocument::parse("scene.toml", &text, &Registry::empty())
    };
    for step in [
        "time-step = \"2*pi/100\"",
        "epsilon = \"pi/100\"\nh = \"2\"",
    ] {
        let document = scene(step).expect("a scene");
        assert_eq!(document.method.step.time_step(), 2.0 * PI / 100.0, "{step}");
        assert_eq!(document.run.steps.value, 200, "{step}");
    }
    for (step, message) in [
        ("time-step = \"start\"", "start"),
        ("time-step = \"pi - pi\"", "different from zero"),
        ("time-step = \"1/0\"", "`time-step`"),
    ] {
        let errors = scene(step).expect_err(step);
        let told = &errors.diagnostics()[0].message;
        assert!(told.contains(message), "{step}: {told}");
    }
}
