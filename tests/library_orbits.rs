//! Systems of the library by their automatic methods, against closed forms, and what their symmetries conserve.
//!
//! The closed forms of `systems/reference/closed_forms.json` are the literature's, evaluated elsewhere at 50 digits and checked
//! there against equations of motion that were not written from the scene texts.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::Walk;
use leafwise::scene::ComposedRun;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, decimal, decimals, distance, largest};
use leafwise_tests::orders::measure;
use leafwise_tests::scenes::composed;
use serde_json::Value;

use crate::runs::{Table, ran};

fn orbits() -> Vec<Value> {
    let text = include_str!("../systems/reference/closed_forms.json");
    let data: Value = serde_json::from_str(text).expect("reference data");
    data["orbits"].as_array().expect("a list of orbits").clone()
}

/// The system with these parameters, and its automatic realization under `hamilton-jacobi` of this order. Families get their
/// share of `coordinates`.
fn automatic(
    id: &str,
    parameters: &[(String, f64)],
    coordinates: usize,
    order: usize,
    step: f64,
) -> ComposedRun {
    let entry = leafwise::systems::find(id).unwrap_or_else(|| panic!("`{id}` is in the library"));
    let text = entry.system().expect("a library text is well formed");
    let initial = entry
        .defaults()
        .expect("a library text has defaults")
        .initial;
    let families = text.get("families").and_then(toml::Value::as_table);
    let families: Vec<_> = families.into_iter().flatten().collect();
    let components = |family: &toml::Value| {
        let names = family.get("components").and_then(toml::Value::as_array);
        names.map_or(1, Vec::len)
    };
    let share: usize = families.iter().map(|(_, family)| components(family)).sum();
    let families: Vec<String> = families
        .iter()
        .map(|(name, _)| format!("{name} = {}", coordinates / share))
        .collect();
    let families = match families.as_slice() {
        [] => String::new(),
        some => format!("families = {{ {} }}\n", some.join(", ")),
    };
    let parameters: Vec<String> = parameters
        .iter()
        .map(|(name, value)| format!("{name} = {value:?}"))
        .collect();
    composed(&format!(
        "[system]\nlibrary = \"{id}\"\n{families}parameters = {{ {} }}\n[method]\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = {step:?}\n\
         [run]\ninitial = {initial}\nsteps = 1\n",
        parameters.join(", ")
    ))
}

/// The coordinates of the scene after so many steps from `initial`.
fn end(run: &ComposedRun, initial: &[f64], steps: usize) -> Vec<f64> {
    // A driven system has the time and its energy behind its coordinates.
    let mut state = run.plan.initial.clone();
    state[..initial.len()].copy_from_slice(initial);
    let parameters = run.system.parameter_values();
    let plan = &run.plan;
    let mut walk = Walk::new(run.method.map(), &parameters, plan.epsilon, plan.h, &state);
    walk.advance(steps as u64).expect("every step");
    walk.state()[..initial.len()].to_vec()
}

/// The order to measure and the numbers of steps to measure it with.
fn plan(id: &str) -> (usize, [usize; 5]) {
    match id {
        "magnetic-field-line" => (6, [14, 19, 27, 38, 55]),
        "driven-pendulum" => (6, [43, 60, 86, 120, 171]),
        "attitude" => (6, [29, 40, 57, 80, 114]),
        "heavy-top-attitude" => (6, [21, 30, 43, 60, 86]),
        "maxwell-bloch" => (6, [32, 45, 64, 90, 129]),
        "sphere-vortices" => (6, [14, 20, 29, 40, 57]),
        "camassa-holm" => (6, [20, 28, 40, 57, 80]),
        "may-leonard" => (6, [40, 57, 80, 114, 160]),
        "nambu" => (6, [50, 71, 100, 143, 200]),
        "spin-chain" => (4, [20, 28, 40, 57, 80]),
        "ablowitz-ladik" => (4, [80, 113, 160, 226, 320]),
        other => panic!("`{other}` has no plan"),
    }
}

/// Fitted orders as declared. Round-off: a unit of the state in each of 16 dozen steps, which these motions magnify little.
#[test]
fn closed_forms_are_followed_with_the_declared_order() {
    for orbit in orbits() {
        let id = orbit["system"].as_str().expect("an orbit names its system");
        let parameters = orbit["parameters"].as_object().expect("parameters by name");
        let parameters: Vec<(String, f64)> = parameters
            .iter()
            .map(|(name, value)| (name.clone(), decimal(value)))
            .collect();
        let (initial, exact) = (decimals(&orbit["initial"]), decimals(&orbit["final"]));
        let time = decimal(&orbit["time"]);
        let (order, steps) = plan(id);
        let points: Vec<(f64, f64)> = steps
            .iter()
            .map(|&steps| {
                let step = time / steps as f64;
                let run = automatic(id, &parameters, initial.len(), order, step);
                (step, distance(&end(&run, &initial, steps), &exact))
            })
            .collect();
        let round_off = 32.0 * UNIT_ROUNDOFF * largest(&exact);
        println!("{id}: {points:?}");
        let measured = measure(&points, round_off, 2.0)
            .unwrap_or_else(|| panic!("{id}: too few errors above round-off: {points:?}"));
        println!("{id}: {measured}");
        assert!(
            measured.is(order as f64, 2.0),
            "{id}: {measured}, not {order}"
        );
    }
}

/// The samples of a scene, by column.
fn samples(text: &str, overrides: &[(&str, &str)]) -> Table {
    let (_, table) = ran(text, overrides);
    table("samples.csv")
}

/// Momenta of symmetries that act linearly commute with the realization and the generating function, so that steps keep them to
/// round-off where they are at most quadratic: four units of 1 for each of 200 steps.
#[test]
fn momenta_of_symmetries_are_kept_to_round_off() {
    let scenes: [(&str, &[&str]); 5] = [
        (
            include_str!("../scenes/attitude.toml"),
            &["norm", "space1", "space2", "space3"],
        ),
        (
            include_str!("../scenes/heavy_top_attitude.toml"),
            &["norm", "vertical"],
        ),
        (
            include_str!("../scenes/maxwell_bloch.toml"),
            &["atoms", "excitations"],
        ),
        (
            include_str!("../scenes/sphere_vortices.toml"),
            &["sphere1", "moment_x", "moment_y", "moment_z"],
        ),
        (
            include_str!("../scenes/spin_chain.toml"),
            &["lengths", "total_x", "total_z"],
        ),
    ];
    for (text, names) in scenes {
        let found = samples(text, &[("run.steps", "200")]);
        for name in names {
            let values = &found[*name];
            let drift = largest(values.iter().map(|value| value - values[0]));
            println!("{name}: {drift:.1e}");
            assert!(
                values.len() > 20 && drift <= 200.0 * 4.0 * UNIT_ROUNDOFF,
                "{name}: {drift:e}"
            );
        }
        let energy = &found["energy"];
        let moved = largest(energy.iter().map(|value| value - energy[0]));
        assert!(
            moved > 0.0 && moved <= 1e-5 * energy[0].abs(),
            "energy: {moved:e}"
        );
    }
}

/// Arenstorf's orbit closes after its period (Hairer, Nørsett, Wanner, II.0): the scene's 1520 paced steps return within 1e-10,
/// and its Jacobi integral, −2 H, is kept to 1e-12 of its value.
#[test]
fn arenstorfs_orbit_closes() {
    let text = include_str!("../scenes/restricted_three_body.toml");
    let found = samples(text, &[("run.record.interval", "1")]);
    for name in ["x", "y", "vx", "vy"] {
        let values = &found[name];
        let gap = (values[values.len() - 1] - values[0]).abs();
        println!("{name}: {gap:.1e}");
        assert!(gap <= 1e-10, "{name}: {gap:e}");
    }
    let jacobi = &found["jacobi"];
    let drift = largest(jacobi.iter().map(|value| value - jacobi[0]));
    assert!(drift <= 1e-12 * jacobi[0], "{drift:e}");
}

/// θ of a field line about q = 2, after every second turn, for 600 turns: inside an island it keeps to one side of the axis, and
/// without the perturbation it goes round, by 2π (2 √(1 − r²)/q0 − 1) = 0.026 each time.
#[test]
fn the_perturbation_opens_islands() {
    let sides = |epsilon: f64| {
        let parameters = [("epsilon".to_owned(), epsilon)];
        let step = std::f64::consts::PI / 24.0;
        let run = automatic("magnetic-field-line", &parameters, 2, 4, step);
        let mut walk = run.walk();
        let mut outside = 0;
        for _ in 0..300 {
            walk.advance(96).expect("every step");
            outside += usize::from(walk.state()[0] > 1.0);
        }
        outside
    };
    assert_eq!(sides(0.002), 300);
    let without = sides(0.0);
    println!("{without} of 300 without the perturbation");
    assert!((100..200).contains(&without), "{without}");
}
