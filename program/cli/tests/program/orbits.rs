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

/// The period of the pendulum from rest at 2, by the mean of arithmetic and geometric means.
fn pendulums_period() -> f64 {
    let (mut a, mut b) = (1.0_f64, libm::cos(1.0));
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
    }
    std::f64::consts::TAU / a
}

/// Two and three turns, in steps that are and are no multiple of these: the orbit is that of one turn.
#[test]
fn several_turns_are_one_orbit() {
    let here = Place::with(PENDULUM);
    for (period, steps, turns) in [("17", "340", 2), ("17.1", "341", 2), ("25.5", "511", 3)] {
        let said = here.leafwise(&[
            "orbit",
            "scene.toml",
            "--json",
            "--period",
            period,
            "--steps",
            steps,
        ]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let json = said.json();
        assert_eq!(json["turns"], turns, "{json}");
        let found = json["period"].as_f64().expect("a number");
        // Of order 8 with steps of 0.05, as the orbit of one turn above.
        assert!((found - pendulums_period()).abs() < 1e-8, "{found}");
    }
    let said = here.leafwise(&["orbit", "scene.toml", "--period", "17"]);
    assert!(
        said.out
            .contains("2 of this orbit make up the one that closed first"),
        "{}",
        said.out
    );
}

/// No step of the method turns the oscillator by a whole turn in this period, and its centre alone closes.
#[test]
fn a_state_that_shrinks_to_rest_is_no_orbit() {
    let scene = PENDULUM
        .replace("p^2/2 - cos(q)", "p^2/2 + q^2/2")
        .replace("order = 8", "order = 4")
        .replace("0.05", "0.1")
        .replace("[2, 0]", "[1, 0]");
    let here = Place::with(&scene);
    let said = here.leafwise(&[
        "orbit",
        "scene.toml",
        "--hold-period",
        "--period",
        "6.2831853",
    ]);
    assert_eq!(said.code, Some(2), "{}", said.out);
    said.says(&["an equilibrium"]);
    // Small orbits are orbits: of the pendulum the period is 2π to a² / 16.
    let small = Place::with(&PENDULUM.replace("[2, 0]", "[1e-4, 0]"));
    let said = small.leafwise(&["orbit", "scene.toml", "--period", "6.2", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let found = said.json()["period"].as_f64().expect("a number");
    assert!((found - std::f64::consts::TAU).abs() < 1e-8, "{found}");
}

#[test]
fn events_that_change_the_state_and_forces_are_refused() {
    let act = "section = { at = \"q = 0\", direction = \"down\", set = { p = \"-0.5*p\" } }\n";
    let scene = PENDULUM.replace("- cos(q)", "+ q^2/2 + 0.1*q^4");
    let here = Place::with(&format!("{scene}{act}"));
    for arguments in [
        &["orbit", "scene.toml"][..],
        &["shadow", "scene.toml"],
        &["tune", "scene.toml", "--shadow", "1e-6"],
        &["tabulate", "scene.toml", "--steps", "8"],
        &["compare", "scene.toml"],
    ] {
        let said = here.leafwise(arguments);
        assert_eq!(said.code, Some(3), "{arguments:?}: {}", said.out);
        said.says(&["where events change the state"]);
    }
    let forced = scene
        .replace("[method]", "[system.forces]\np = \"-0.1*p\"\n[method]")
        .replace("{ name = \"hamilton-jacobi\", order = 8 }", "\"one-form\"");
    let here = Place::with(&forced);
    let said = here.leafwise(&["orbit", "scene.toml"]);
    assert_eq!(said.code, Some(2), "{}", said.out);
    said.says(&[
        "a motion with forces or friction does not keep the energy",
        "take system.forces out",
    ]);
}

/// Both ends of the family, as text, JSON and files.
#[test]
fn a_family_is_followed() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&["orbit", "scene.toml", "--continue", "energy=0.6"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for piece in [
        "A family of periodic orbits of",
        "largest multiplier",
        "0.6",
    ] {
        assert!(said.out.contains(piece), "{piece} in {}", said.out);
    }
    let said = here.leafwise(&[
        "orbit",
        "scene.toml",
        "--continue",
        "period=9",
        "--json",
        "--out",
        "family",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["along"], "period");
    assert_eq!(json["ends"], "reached");
    let orbits = json["orbits"].as_array().expect("orbits");
    let last = orbits.last().expect("one");
    assert_eq!(last["value"], 9.0);
    // Of the period 9 = 2π/M(1, cos(A/2)) and the energy −cos A.
    let half = libm::acos(-last["energy"].as_f64().expect("a number")) / 2.0;
    let (mut a, mut b) = (1.0_f64, libm::cos(half));
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), libm::sqrt(a * b));
    }
    assert!((std::f64::consts::TAU / a - 9.0).abs() < 1e-7);
    let table = here.read("family/family.csv");
    assert!(
        table.starts_with("value,mark,energy,period,largest_multiplier,stable,q,p\n"),
        "{table}"
    );
    assert_eq!(table.lines().count(), orbits.len() + 1);
    assert!(here.read("family/family.svg").contains("<svg"));
    assert!(here.read("family/family.json").contains("\"reached\""));
    // Orbits of the pendulum shrink to its equilibrium of the energy −1.
    let small = Place::with(&PENDULUM.replace("[2, 0]", "[0.3, 0]"));
    let said = small.leafwise(&[
        "orbit",
        "scene.toml",
        "--period",
        "6.3",
        "--continue",
        "energy=-2",
    ]);
    assert_eq!(said.code, Some(6), "{}", said.out);
    said.says(&["ends at an equilibrium"]);
    let said = here.leafwise(&[
        "orbit",
        "scene.toml",
        "--continue",
        "energy=0.6",
        "--orbits",
        "2",
    ]);
    assert_eq!(said.code, Some(6));
    said.says(&["give more --orbits"]);
    for (given, piece) in [
        ("energy", "names no value"),
        ("mass=2", "no parameter `mass`"),
        ("energy=nan", "another value"),
    ] {
        let said = here.leafwise(&["orbit", "scene.toml", "--continue", given]);
        assert_eq!(said.code, Some(2), "{given}");
        said.says(&[piece]);
    }
}

#[test]
fn an_equilibrium_is_judged() {
    let here = Place::with(&PENDULUM.replace("[2, 0]", "[3, 0.1]"));
    let said = here.leafwise(&["orbit", "scene.toml", "--equilibrium"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        said.out
            .contains("unstable: neighbours diverge exponentially"),
        "{}",
        said.out
    );
    let json = here
        .leafwise(&["orbit", "scene.toml", "--equilibrium", "--json"])
        .json();
    assert_eq!(json["stability"], "unstable");
    assert_eq!(json["leaf"], 2);
    let q = json["state"]["q"].as_f64().expect("a number");
    assert!((q - std::f64::consts::PI).abs() < 1e-12, "{q}");
    let down = Place::with(&PENDULUM.replace("[2, 0]", "[0.2, 0.1]"));
    let json = down
        .leafwise(&["orbit", "scene.toml", "--equilibrium", "--json"])
        .json();
    assert_eq!(json["stability"], "stable");
    let none = Place::with(
        &PENDULUM
            .replace("p^2/2 - cos(q)", "p + q")
            .replace("[2, 0]", "[1, 1]"),
    );
    let said = none.leafwise(&["orbit", "scene.toml", "--equilibrium"]);
    assert_eq!(said.code, Some(2));
    said.says(&["no equilibrium near here"]);
    let both = here.leafwise(&["orbit", "scene.toml", "--equilibrium", "--period", "6"]);
    assert_eq!(both.code, Some(2));
}
