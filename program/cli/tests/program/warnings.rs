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

/// Flaschka's open chain, an empty site: Σ ln a has no value, the motion has. What is advised silences the warning.
#[test]
fn a_casimir_without_a_value_at_the_start_is_a_warning() {
    let scene = |casimirs: &str| {
        format!(
            "[system]\nlibrary = \"toda\"\n{casimirs}[method]\nrealization = \"auto\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 0.02\n[run]\n\
             initial = {{ \"a[i]\" = \"0.5\", \"b[i]\" = \"0.1*cos(i)\", \"a[15]\" = 0 }}\nsteps = 50\n"
        )
    };
    let here = Place::with(&scene(""));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&[
        "`logarithm` has no finite value at the initial state",
        "change: casimirs = {} in [system]",
    ]);
    here.write("scene.toml", &scene("casimirs = {}\n"));
    let said = here.leafwise(&["run", "scene.toml", "--out", "other"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(!said.err.contains("no finite value"), "{}", said.err);
}

/// Predators without prey: ln x has no value at x = 0, where y falls as e^(-3t).
#[test]
fn an_energy_without_a_value_at_the_start_is_a_warning() {
    let here = Place::with(
        "[system]\nvariables = [\"x\", \"y\"]\nbracket = { \"x,y\" = \"x*y\" }\nconvention = \"{x,H}\"\n\
         hamiltonian = \"x - 3*ln(x) + y - ln(y)\"\n[method]\nrealization = \"auto\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.05\n[run]\n\
         initial = [0, 1]\nsteps = 20\n",
    );
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["`energy` has no finite value at the initial state"]);
}
