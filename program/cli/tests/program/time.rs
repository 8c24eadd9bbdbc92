//! Scenes whose Hamiltonian names the time: nothing outside shows the coordinates behind it.

use crate::support::Place;

/// x'' = -x - 0.1 cos t.
const DRIVEN: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 + q^2/2 + 0.1*q*cos(t)"
[method]
dynamics    = { name = "hamilton-jacobi", order = 4 }
time-step   = 0.1
[run]
initial = [1, 0.5]
steps   = 40
record  = { every = 4, observables = ["energy", "q - t"] }
"#;

/// The rows of a table of numbers behind its headings.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| {
        let cells = line.split(',');
        cells.map(|cell| cell.parse().expect("a number")).collect()
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn a_run_shows_the_scenes_own_coordinates_alone() {
    let here = Place::with(DRIVEN);
    let told = here
        .leafwise(&["run", "scene.toml", "--out", "run", "--json"])
        .json();
    assert_eq!(told["outcome"], "done");
    assert_eq!(told["final_state"].as_array().map(Vec::len), Some(2));
    let samples = here.read("run/samples.csv");
    assert_eq!(samples.lines().next(), Some("t,q,p,energy,q - t"));
    let rows = rows(&samples);
    assert_eq!(rows.len(), 11);
    for row in &rows {
        assert_eq!(row[4], row[1] - row[0], "an observable has the time");
        // The balance: order 4 at steps of 0.1 keeps it to 1e-6.
        assert!((row[3] - 0.725).abs() < 1e-6, "{row:?}");
    }
    assert!(!here.path("run/final_state.bin").exists());
    let manifest: serde_json::Value =
        serde_json::from_str(&here.read("run/manifest.json")).expect("JSON");
    assert_eq!(manifest["dimension"], 2);
    assert_eq!(manifest["variables"], serde_json::json!(["q", "p"]));
    assert_eq!(manifest["initial"], serde_json::json!([1.0, 0.5]));
    assert_eq!(manifest["tensor"], "constant");
    let motion = here.leafwise(&["check", "scene.toml", "--json"]).json();
    let formulas = motion["motion"]["formulas"].as_object().expect("formulas");
    assert_eq!(formulas.keys().collect::<Vec<_>>(), ["q", "p"]);
}

#[test]
fn a_run_that_goes_on_has_the_same_bytes() {
    let here = Place::with(DRIVEN);
    let run = |steps: &str, out: &str| {
        let steps = format!("run.steps={steps}");
        let said = here.leafwise(&["run", "scene.toml", "--set", &steps, "--out", out]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    };
    run("40", "longer");
    run("90", "longer");
    run("90", "whole");
    assert_eq!(here.read("longer/samples.csv"), here.read("whole/samples.csv"));
}

#[test]
fn a_member_of_an_ensemble_is_its_run_to_the_bit() {
    for initial in ["ball = 0.1", "box = [0.1, 0.2]", "file = \"states.csv\""] {
        let members = if initial.starts_with("file") { 2 } else { 5 };
        let here = Place::with(&format!(
            "{DRIVEN}[ensemble]\nmembers = {members}\ninitial = {{ {initial} }}\nfinal-states = \"csv\"\n"
        ));
        here.write("states.csv", "p,q\n0.5,1\n0.25,-1\n");
        let said = here.leafwise(&["ensemble", "scene.toml", "--out", "all"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let table = here.read("all/final_states.csv");
        let headings = "member,outcome,q,p,energy,q_initial,p_initial,energy_drift";
        assert_eq!(table.lines().next(), Some(headings));
        let member = table.lines().nth(2).expect("a member");
        let last: Vec<&str> = member.split(',').collect();
        let said = here.leafwise(&["ensemble", "scene.toml", "--member", "1", "--out", "one"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read("one/samples.csv");
        let end: Vec<&str> = samples.lines().last().expect("a row").split(',').collect();
        assert_eq!(end[1..3], last[2..4], "{initial}");
    }
}

#[test]
fn methods_are_compared_by_the_scenes_own_coordinates() {
    let here = Place::with(DRIVEN);
    let only = "splitting,hamilton-jacobi:4";
    let compared = ["compare", "scene.toml", "--steps", "40,80", "--only", only, "--json"];
    let told = here.leafwise(&compared).json();
    let state = told["reference"]["state"].as_array().expect("a state");
    // x(4) = cos 4 + 0.5 sin 4 − 0.2 sin 4.
    let exact = libm::cos(4.0) + 0.3 * libm::sin(4.0);
    let found = state[0].as_f64().expect("a number");
    assert_eq!(state.len(), 2);
    assert!((found - exact).abs() < 1e-12, "{found}");
    let tune = here.leafwise(&["tune", "scene.toml", "--error", "1e-6", "--json"]);
    assert_eq!(tune.code, Some(0), "{}", tune.err);
}

/// Runs the scene with one text changed, which must be refused at `place` with every piece said.
fn refused(from: &str, to: &str, place: &str, pieces: &[&str]) {
    assert!(DRIVEN.contains(from), "{from}");
    let here = Place::with(&DRIVEN.replacen(from, to, 1));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[&format!("scene.toml:{place}")]);
    said.says(pieces);
    assert!(here.is_untouched(), "something was written");
}

#[test]
fn the_time_stands_where_it_has_a_meaning() {
    let bracket = ["the bracket cannot name the time t", "belongs into the Hamiltonian"];
    refused("\"1\" }", "\"1 + t\" }", "3:29", &bracket);
    refused(
        "[method]",
        "casimirs = { c = \"t\" }\n[method]",
        "6:19",
        &["a Casimir cannot name the time t"],
    );
    refused(
        "[1, 0.5]",
        "{ q = \"t\", p = 1 }",
        "10:18",
        &["every run begins at t = 0", "phase"],
    );
    let unnamed = ["the Hamiltonian does not name the time t"];
    refused("0.1*q*cos(t)", "0.1*q", "12:55", &unnamed);
    // A coordinate, or a parameter, of this name is no time.
    let own = DRIVEN.replace("[method]", "parameters = { t = 0.5 }\n[method]");
    let here = Place::with(&own);
    let said = here.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(said.out.contains("-q - 0.1*cos(t)"), "{}", said.out);
}

#[test]
fn what_is_not_offered_with_the_time_says_so() {
    let lattice = DRIVEN
        .replace("variables   = [\"q\", \"p\"]", "families = { q = 64, p = 64 }")
        .replace("\"q,p\"", "\"q[i],p[i]\"")
        .replace("p^2/2 + q^2/2 + 0.1*q*cos(t)", "sum(i, p[i]^2/2 + q[i]^2*cos(t))")
        .replace("[1, 0.5]", "{ \"q[i]\" = 1, \"p[i]\" = 0 }")
        .replace(", \"q - t\"", "");
    let here = Place::with(&lattice);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&["not offered on a lattice of more than 24 coordinates", "this one has 128"]);
    let here = Place::with(DRIVEN);
    let said = here.leafwise(&["evaluate", "scene.toml", "--x", "1,0"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["names the time t is not evaluated at a point"]);
}
