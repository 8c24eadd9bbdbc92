//! The shadow Hamiltonian of a method: the command, the observable, what is told of a step.

use crate::support::{Place, Said};

const PENDULUM: &str = r#"[system]
variables   = ["q", "p"]
bracket     = { "q,p" = "1" }
convention  = "{x,H}"
hamiltonian = "p^2/2 - cos(q)"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.1
[run]
initial = [1.5, 0]
steps   = 500
record  = { every = 1, observables = ["energy", "shadow-energy"] }
"#;

fn set(here: &Place, command: &str, set: &[&str]) -> Said {
    let mut arguments = vec![command, "scene.toml", "--json"];
    if command == "run" {
        arguments.push("--force");
    }
    set.iter().for_each(|set| arguments.extend(["--set", set]));
    here.leafwise(&arguments)
}

#[test]
fn the_pendulums_formulas_are_those_of_the_midpoint_rule() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["shadow", "scene.toml", "--order", "4"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    // -(H_qq f_q² + H_pp f_p²)/24 with f = (p, -sin q).
    for line in [
        "H~ = F_1 + t^2 F_3, t = 0.1",
        "p^2/2 - cos(q)",
        "-p^2*cos(q)/24",
        "the step is in the range of the theory",
    ] {
        assert!(said.out.contains(line), "{line}\n{}", said.out);
    }
}

#[test]
fn the_step_and_the_time_have_two_names() {
    let here = Place::with(&PENDULUM.replace("- cos(q)", "- cos(q) + 0.1*q*sin(t)"));
    let said = here.leafwise(&["shadow", "scene.toml", "--order", "4"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for line in [
        "H~ = F_1 + h^2 F_3, h = 0.1",
        "0.1*q*sin(t)",
        "p^2/2 + e - cos(q)\n",
        "e' = -dH/dt, and H + e is constant",
    ] {
        assert!(said.out.contains(line), "{line}\n{}", said.out);
    }
}

#[test]
fn a_run_says_whether_its_step_is_in_the_range_of_the_theory() {
    let here = Place::with(PENDULUM);
    let fine = set(
        &here,
        "run",
        &["run.record.observables=[\"energy\", \"shadow-energy of order 8\"]"],
    );
    let fine = fine.json();
    let told = &fine["shadow"];
    assert_eq!(told["is_in_range"], true, "{told}");
    assert_eq!(told["order"], 8);
    let change = |name: &str| told[name].as_f64().expect("a number");
    // Three terms of t²/24 or less each.
    assert!(change("shadow") < change("energy") / 13_824.0, "{told}");
    let coarse = set(
        &here,
        "run",
        &[
            "method.time-step=1.2",
            "run.record.observables=[\"energy\", \"shadow-energy of order 8\"]",
        ],
    );
    let coarse = coarse.json();
    let told = &coarse["shadow"];
    assert_eq!(told["is_in_range"], false, "{told}");
    let step = told["step"].as_f64().expect("a step");
    assert!(step < 1.2, "{step}");
    // The step that it names is in range.
    let named = format!("method.time-step={step}");
    let named = set(
        &here,
        "run",
        &[
            &named,
            "run.record.observables=[\"energy\", \"shadow-energy of order 8\"]",
        ],
    );
    assert_eq!(named.json()["shadow"]["is_in_range"], true);
}

#[test]
fn an_ensemble_records_it() {
    let scene = format!(
        "{PENDULUM}[ensemble]\nmembers = 8\ninitial = {{ ball = 0.1 }}\nrecord = {{ every = 100, observables = \
         [\"energy\", \"shadow-energy\"] }}\n"
    );
    let here = Place::with(&scene);
    let said = here.leafwise(&["ensemble", "scene.toml", "--out", "cloud", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let table = std::fs::read_to_string(here.path("cloud/statistics.csv")).expect("statistics");
    assert!(
        table.lines().any(|line| line.contains("shadow-energy")),
        "{table}"
    );
}

#[test]
fn what_has_none_is_refused_where_it_stands() {
    let here = Place::with(PENDULUM);
    for (change, message) in [
        (
            "run.record.observables=[\"shadow-energy of order 5\"]",
            "has no shadow Hamiltonian of order 5",
        ),
        (
            "run.record.observables=[\"shadow-enrgy\"]",
            "did you mean `shadow-energy`?",
        ),
        (
            "method={ stepper = \"rk4\", time-step = 0.1 }",
            "has no formula of its shadow Hamiltonian",
        ),
        ("method.pace=\"1 + q^2\"", "with a pace"),
    ] {
        let said = set(&here, "run", &[change]);
        assert_eq!(said.code, Some(3), "{change}\n{}", said.err);
        assert!(said.err.contains(message), "{message}\n{}", said.err);
    }
    let here = Place::with(&PENDULUM.replace(", \"shadow-energy\"", ""));
    // Where no step can be made, nothing is said of it: y − (t²/4) y² = 3/2 has no solution.
    let falls = "system.hamiltonian=\"p^2/2 - q^3/3\"";
    let long = set(&here, "shadow", &[falls, "method.time-step=50"]);
    assert_eq!(long.code, Some(1), "{}", long.out);
    long.says(&["failed: the solution of the step's equation"]);
    let said = set(
        &here,
        "shadow",
        &["method={ stepper = \"rk4\", time-step = 0.1 }"],
    );
    assert_eq!(said.code, Some(2), "{}", said.err);
}

#[test]
fn a_step_is_found_from_the_shadow_alone() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["tune", "scene.toml", "--shadow", "1e-8", "--json"]);
    let told = said.json();
    let number = |key: &str| told[key].as_f64().expect("a number");
    let (step, change) = (number("time_step"), number("shadow"));
    assert!((2.5e-9..=1e-8).contains(&change), "{told}");
    // The change is of order 4: twice the step would change it 16 times as much.
    let twice = format!("method.time-step={}", 2.0 * step);
    let coarse = set(&here, "shadow", &[&twice]).json();
    let ratio = coarse["shadow"].as_f64().expect("a number") / change;
    assert!((ratio / 16.0 - 1.0).abs() < 0.1, "{ratio}");
    let lines = here.leafwise(&["tune", "scene.toml", "--shadow", "1e-8"]);
    assert!(lines.out.starts_with("time-step = 0.0"), "{}", lines.out);
    // Shorter than round-off lets it be.
    let never = here.leafwise(&["tune", "scene.toml", "--shadow", "1e-30"]);
    assert_eq!(never.code, Some(5), "{}", never.err);
    never.says(&["no step keeps it so"]);
    let both = here.leafwise(&["tune", "scene.toml", "--shadow", "1e-8", "--error", "1e-8"]);
    assert_eq!(both.code, Some(2), "{}", both.err);
}
