//! What a run warns of: an energy kept badly, observables without a value, parameters without a use.

use crate::support::{BODY, Place};

/// The Kepler problem from perihelion, eccentricity 0.6.
const KEPLER: &str = r#"[system]
variables   = ["q1", "q2", "p1", "p2"]
bracket     = { "q1,p1" = "1", "q2,p2" = "1" }
convention  = "{x,H}"
hamiltonian = "(p1^2 + p2^2)/2 - 1/sqrt(q1^2 + q2^2)"
[method]
stepper   = "splitting"
time-step = 0.3
[run]
initial = [0.4, 0, 0, 2]
steps   = 200
"#;

#[test]
fn a_large_error_of_the_energy_warns() {
    let warning = "of its scale along the orbit";
    let here = Place::with(KEPLER);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0));
    said.says(&["the energy is off by", warning, "time-step = 0.15"]);
    assert!(here.read("runs/scene/report.html").contains(warning));
    // A constant in H and other units change nothing.
    let shifted = KEPLER.replace("hamiltonian = \"(", "hamiltonian = \"1000 + (");
    let said = Place::with(&shifted).leafwise(&["run", "scene.toml"]);
    said.says(&[warning]);
    // Of a step that is small enough nothing is said.
    let fine = [
        "run",
        "scene.toml",
        "--force",
        "--set",
        "method.time-step=0.01",
    ];
    let said = here.leafwise(&fine);
    assert!(!said.err.contains(warning), "{}", said.err);
    let members = "[ensemble]\nmembers = 3\ninitial = { ball = 0.001 }\n";
    let here = Place::with(&format!("{KEPLER}{members}"));
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    said.says(&["the energy of member", warning]);
    assert!(
        here.read("runs/scene-ensemble/report.html")
            .contains(warning)
    );
}

#[test]
fn an_observable_without_a_value_is_reported_with_its_first_time() {
    let here = Place::with_body(
        "observables = [\"energy\", \"spin\"]",
        "observables = [\"energy\", \"ln(x1)\", { root = \"sqrt(x2 + 100)\" }]",
    );
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0));
    let samples = here.read("runs/scene/samples.csv");
    let first = samples
        .lines()
        .find(|row| row.contains("NaN"))
        .expect("x1 changes its sign");
    let time: f64 = first
        .split(',')
        .next()
        .expect("a cell")
        .parse()
        .expect("a time");
    let expected = format!("first at t = {}", (time * 1e6).round() / 1e6);
    said.says(&["`ln(x1)` has no finite value at ", &expected]);
    assert!(!said.err.contains("`root`"), "{}", said.err);
    let json = said.json();
    let warnings = json["warnings"].as_array().expect("a list");
    assert!(
        warnings
            .iter()
            .any(|warning| warning["kind"] == "undefined-observable"),
        "{warnings:?}"
    );
    let members = "[ensemble]\nmembers = 4\nrecord = { every = 3, observables = [\"ln(x1)\"] }\n";
    let here = Place::with(&format!("{BODY}{members}"));
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    said.says(&["`ln(x1)` has no finite value for 4 of 4 members, first at t = "]);
}

#[test]
fn a_parameter_that_nothing_depends_on_is_reported() {
    let here = Place::with_body("I3 = 1.25 }", "I3 = 1.25, I4 = 2 }");
    for command in ["check", "run"] {
        let said = here.leafwise(&[command, "scene.toml"]);
        assert_eq!(said.code, Some(0));
        said.says(&["nothing depends on the parameter `I4`"]);
        assert!(!said.err.contains("`I3`"), "{}", said.err);
    }
}
