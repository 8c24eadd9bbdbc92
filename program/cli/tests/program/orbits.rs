//! `leafwise orbit`: text, JSON, options and refusals.

use crate::support::Place;

const PENDULUM: &str = r#"[system]
variables   = ["q", "p"]
bracket     = "canonical"
hamiltonian = "p^2/2 - cos(q)"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 8 }
time-step   = 0.05
[run]
initial = [2, 0]
steps   = 170
"#;

#[test]
fn an_orbit_is_closed() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["orbit", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for piece in [
        "A periodic orbit of",
        "period",
        "closes to",
        "2 multipliers are 1",
    ] {
        assert!(said.out.contains(piece), "{piece} in {}", said.out);
    }
    let said = here.leafwise(&["orbit", "scene.toml", "--json"]);
    let json = said.json();
    let (mut a, mut b) = (1.0_f64, libm::cos(1.0));
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
    }
    let period = json["period"].as_f64().expect("a number");
    assert!(
        (period - std::f64::consts::TAU / a).abs() < 1e-8,
        "{period}"
    );
    assert_eq!(json["stable"], true);
    assert_eq!(json["steps"], 170);
    let held = here.leafwise(&[
        "orbit",
        "scene.toml",
        "--json",
        "--hold-period",
        "--period",
        "9",
        "--steps",
        "200",
    ]);
    assert_eq!(held.json()["period"], 9.0, "{}", held.err);
    assert_eq!(held.json()["steps"], 200);
}

#[test]
fn what_does_not_close_is_told() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["orbit", "scene.toml", "--period", "-1"]);
    assert_eq!(said.code, Some(2));
    assert!(said.err.contains("no period"), "{}", said.err);
    let free = Place::with(
        &PENDULUM
            .replace("p^2/2 - cos(q)", "p^2/2")
            .replace("[2, 0]", "[1, 1]"),
    );
    let said = free.leafwise(&["orbit", "scene.toml"]);
    assert_eq!(said.code, Some(2));
    assert!(
        said.err.contains("no orbit closes near here"),
        "{}",
        said.err
    );
    assert!(said.err.contains("shrinks to zero"), "{}", said.err);
    let rests = Place::with(&PENDULUM.replace("[2, 0]", "[0, 0]"));
    let said = rests.leafwise(&["orbit", "scene.toml"]);
    assert_eq!(said.code, Some(2));
    assert!(said.err.contains("an equilibrium"), "{}", said.err);
    let timed = Place::with(&PENDULUM.replace("cos(q)", "cos(q) + 0.1*q*cos(t)"));
    let said = timed.leafwise(&["orbit", "scene.toml"]);
    assert!(said.err.contains("names the time"), "{}", said.err);
}
