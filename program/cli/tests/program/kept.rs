//! Exact energy and contact systems, in runs, ensembles, sweeps, checks and refusals.

use crate::support::{Place, Said};

const BODY: &str = r#"[system]
library = "rigid-body"
[method]
realization = "so3-cayley"
dynamics    = { name = "hamilton-jacobi", order = 4 }
energy      = "exact"
time-step   = 0.1
[run]
initial = [1, 3, 3]
steps   = 200
record  = { every = 10, observables = ["energy", "spin"] }
"#;

const OSCILLATOR: &str = r#"[system]
variables   = ["q", "p", "s"]
parameters  = { gamma = 0.2 }
bracket     = "contact"
hamiltonian = "p^2/2 + q^2/2 + gamma*s"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 4 }
time-step   = 0.1
[run]
initial = [1, 0, 0]
steps   = 200
record  = { every = 10, observables = ["energy", { mechanical = "p^2/2 + q^2/2" }] }
"#;

fn said(here: &Place, arguments: &[&str]) -> Said {
    let said = here.leafwise(arguments);
    assert_eq!(said.code, Some(0), "{arguments:?}: {}", said.err);
    said
}

/// The numbers of the last row of a run's samples.
fn last(here: &Place, directory: &str) -> Vec<f64> {
    let rows = here.read(&format!("runs/{directory}/samples.csv"));
    let row = rows.lines().last().expect("a row");
    let numbers = row
        .split(',')
        .map(|number| number.parse().expect("a number"));
    numbers.collect()
}

/// Members and settings end where runs do; an ensemble's columns depend on no lanes.
fn is_the_same_everywhere(scene: &str, parameter: &str, coordinates: usize) {
    let many = "[ensemble]\nmembers = 5\ninitial = { ball = 0.1 }\nfinal-states = \"csv\"\n";
    let here = Place::with(&format!("{scene}{many}"));
    let mut tables = Vec::new();
    for lanes in ["1", "4"] {
        said(
            &here,
            &["ensemble", "scene.toml", "--out", lanes, "--lanes", lanes],
        );
        tables.push(here.read(&format!("{lanes}/final_states.csv")));
    }
    assert_eq!(tables[0], tables[1]);
    said(&here, &["ensemble", "scene.toml", "--member", "3"]);
    let alone = last(&here, "scene-member-3");
    let row = tables[0].lines().nth(4).expect("a row").to_owned();
    for coordinate in &alone[1..=coordinates] {
        assert!(
            row.contains(&coordinate.to_string()),
            "{coordinate} in {row}"
        );
    }
    let sweep = format!("[sweep]\ngrid = {{ \"system.parameters.{parameter}\" = [0.7, 0.8] }}\n");
    let here = Place::with(&format!("{scene}{sweep}"));
    said(&here, &["sweep", "scene.toml"]);
    let table = here.read("runs/scene-sweep/sweep.csv");
    let set = format!("system.parameters.{parameter}=0.8");
    said(&here, &["run", "scene.toml", "--set", &set]);
    let alone = last(&here, "scene");
    let row = table.lines().nth(2).expect("a row");
    let energy = format!("{:?}", alone[4]);
    assert!(row.contains(&energy), "{alone:?} in {row}");
}

#[test]
fn exact_energy_is_the_same_everywhere() {
    is_the_same_everywhere(BODY, "I2", 3);
    let here = Place::with(BODY);
    let run = said(&here, &["run", "scene.toml", "--explain"]);
    run.says(&["not a Poisson map"]);
    let run = said(&here, &["run", "scene.toml"]);
    run.says(&["the whole is not a Poisson map"]);
    let end = last(&here, "scene");
    let energy = 0.5 + 9.0 / 1.5 + 9.0 / 2.5;
    assert!(
        (end[4] / energy - 1.0).abs() <= 2.0 * f64::EPSILON,
        "{end:?}"
    );
    assert!((end[5] / 19.0 - 1.0).abs() <= 2e-15, "{end:?}");
}

#[test]
fn exact_energy_refuses_tangents() {
    let here = Place::with(BODY);
    let refused = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "run.record.observables=[\"megno\"]",
    ]);
    assert_eq!(refused.code, Some(3));
    assert!(
        refused.err.contains("remove `energy` from [method]"),
        "{}",
        refused.err
    );
}

#[test]
fn contact_systems_are_the_same_everywhere() {
    is_the_same_everywhere(OSCILLATOR, "gamma", 3);
    let here = Place::with(OSCILLATOR);
    let run = said(&here, &["run", "scene.toml", "--explain"]);
    run.says(&["a contact map, to round-off"]);
    let header = here.read("runs/scene/samples.csv");
    assert!(
        header.starts_with("t,q,p,s,energy,mechanical\n"),
        "{header}"
    );
    // H falls like e^{-t/5}.
    let end = last(&here, "scene");
    assert!((end[4] - 0.5 * libm::exp(-4.0)).abs() < 1e-6, "{end:?}");
    assert!(!run.err.contains("warning"), "{}", run.err);
}

#[test]
fn contact_systems_have_events_and_indicators() {
    let here = Place::with(OSCILLATOR);
    let stop = here.leafwise(&["run", "scene.toml", "--set", "run.stop=q < 0", "--json"]);
    assert_eq!(stop.code, Some(0), "{}", stop.err);
    let end = last(&here, "scene");
    assert!(end[1].abs() < 1e-12, "{end:?}");
    // tan(ωt) = −ω/0.1 of e^{−t/10}(cos ωt + 0.1/ω sin ωt).
    let omega = libm::sqrt(0.99);
    let at = (std::f64::consts::PI - libm::atan(omega / 0.1)) / omega;
    assert!((end[0] - at).abs() < 1e-5, "{} {at}", end[0]);
    let record = "run.record.observables=[\"megno\", \"lyapunov\"]";
    let chaos = said(
        &here,
        &[
            "run",
            "scene.toml",
            "--set",
            record,
            "--set",
            "run.steps=2000",
            "--force",
        ],
    );
    // The slowest of e^{−t/10} and e^{−t/5}.
    let exponent = *last(&here, "scene").last().expect("a column");
    assert!((exponent + 0.1).abs() < 0.02, "{exponent} {}", chaos.err);
}

/// The scene's own method is measured on the homogeneous system, as all others.
#[test]
fn contact_systems_are_verified() {
    let here = Place::with(OSCILLATOR);
    let done = here.leafwise(&["verify", "scene.toml"]);
    assert_eq!(done.code, Some(0), "{}{}", done.out, done.err);
    // Methods for the scene itself have no tensor to be measured by, and the bracket has no Casimirs.
    let compared = said(&here, &["compare", "scene.toml", "--json"]).json();
    let points = compared["points"].as_array().expect("points");
    assert!(points.len() > 10);
    assert!(points.iter().all(|point| point["tensor_defect"].is_null()));
    let found = here.leafwise(&["find", "scene.toml"]);
    assert_eq!(found.code, Some(2));
    assert!(found.err.contains("has no Casimirs"), "{}", found.err);
}

/// q' = ∂H/∂p, p' = −∂H/∂q − p ∂H/∂s, s' = p ∂H/∂p − H, of either convention.
#[test]
fn contact_motions_are_printed() {
    let motion = |scene: &str| {
        let here = Place::with(scene);
        said(&here, &["check", "scene.toml", "--json"]).json()["motion"].clone()
    };
    let own = motion(OSCILLATOR);
    assert_eq!(own["q"], "p");
    assert_eq!(own["p"], "-q - gamma*p");
    assert_eq!(own["s"], "-q^2/2 + p^2/2 - gamma*s");
    let other = "bracket     = \"contact\"\nconvention  = \"{x,H}\"";
    let other = OSCILLATOR.replace("bracket     = \"contact\"", other);
    assert_eq!(motion(&other), own);
    let here = Place::with(OSCILLATOR);
    let heading = "q' = dH/dp, p' = -dH/dq - p dH/ds, s' = p dH/dp - H";
    let text = said(&here, &["check", "scene.toml"]).out;
    assert!(text.contains(heading), "{text}");
}

#[test]
fn checks_take_them() {
    for scene in [BODY, OSCILLATOR] {
        let here = Place::with(scene);
        let done = here.leafwise(&["check", "scene.toml"]);
        assert_eq!(done.code, Some(0), "{}{}", done.out, done.err);
    }
}
