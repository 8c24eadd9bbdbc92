//! All that a trajectory does, on a Volterra lattice and a ring of spins with 1000 sites: it works, or a sentence names the mathematics that
//! forbids it. Gradients there are claims of `tests/gradients/lattices.rs`.

use crate::support::{Place, Said};

const VOLTERRA: &str = r#"[system]
families    = { x = 1000 }
bracket     = { "x[i],x[i+1]" = "x[i]*x[i+1]" }
boundary    = "periodic"
hamiltonian = "sum(i, x[i])"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.05
[run]
initial = { "x[i]" = "1 + 0.1*sin(2*pi*i/N)" }
steps   = 20
record  = { every = 5, states = ["x[0]"], observables = ["energy"] }
"#;

/// A spiral of wave number π/2 on a cone: it turns about the axis by ω = 2·0.8·(1 − cos π/2) = 1.6 a unit of time.
const SPIRAL: &str = r#"[system]
families    = { s = { components = ["x", "y", "z"], length = 1000 } }
boundary    = "periodic"
bracket     = { lie-algebra = "so3" }
hamiltonian = "sum(i, -s.x[i]*s.x[i+1] - s.y[i]*s.y[i+1] - s.z[i]*s.z[i+1])"
[method]
stepper     = "spherical-midpoint"
time-step   = 0.05
[run]
initial = { "s.x[i]" = "0.6*cos(pi*i/2)", "s.y[i]" = "0.6*sin(pi*i/2)", "s.z[i]" = "0.8" }
steps   = 40
record  = { every = 5, states = ["s.x[0]"], observables = ["energy"] }
"#;

/// ω, and the largest relative error of the midpoint rule's, (ωh)²/12, with room for a half.
const TURNS: f64 = 1.6;
const SLOWER: f64 = 1e-3;

fn run(scene: &str, set: &[&str]) -> (Place, Said) {
    let here = Place::with(scene);
    let set = set.iter().flat_map(|value| ["--set", value]);
    let arguments: Vec<&str> = ["run", "scene.toml", "--out", "out", "--json"]
        .into_iter()
        .chain(set)
        .collect();
    let said = here.leafwise(&arguments);
    (here, said)
}

fn works(scene: &str, set: &[&str]) -> (Place, serde_json::Value) {
    let (here, said) = run(scene, set);
    assert_eq!(said.code, Some(0), "{set:?}: {}", said.err);
    let json = said.json();
    (here, json)
}

fn rows(here: &Place, file: &str) -> Vec<Vec<f64>> {
    let text = here.read(&format!("out/{file}"));
    let row = |line: &str| {
        line.split(',')
            .map(|cell| cell.parse().expect("a number"))
            .collect()
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn conditions_sections_and_times_work() {
    let (_, told) = works(SPIRAL, &["run.stop=\"s.x[0] < 0.3\""]);
    assert_eq!(told["outcome"], "stopped");
    let phase = TURNS * told["time"].as_f64().expect("a time");
    let third = std::f64::consts::FRAC_PI_3;
    assert!((phase - third).abs() < SLOWER * third, "{phase}");
    let set = [
        "run.section={ at = \"s.x[0] = 0\" }",
        "run.record={ times = [0.33, 0.71], states = [\"s.x[0]\"] }",
    ];
    let (here, _) = works(SPIRAL, &set);
    let crossed = rows(&here, "section.csv");
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_eq!(crossed.len(), 1, "{crossed:?}");
    assert!(
        (TURNS * crossed[0][0] - quarter).abs() < SLOWER * quarter,
        "{crossed:?}"
    );
    for row in rows(&here, "samples.csv") {
        let (exact, phase) = (0.6 * libm::cos(TURNS * row[0]), TURNS * row[0]);
        assert!(
            (row[1] - exact).abs() <= 0.6 * SLOWER * phase + 1e-14,
            "{row:?}, {exact}"
        );
    }
    // The same of the Volterra lattice, whose x_0 falls from 1 by 1.3e-3 a unit of time: against rk4, of order 4.
    let (_, told) = works(VOLTERRA, &["run.stop=\"x[0] < 0.9995\""]);
    assert_eq!(told["outcome"], "stopped");
    let stopped = told["time"].as_f64().expect("a time");
    let state = told["final_state"][0].as_f64().expect("a coordinate");
    assert!(state < 0.9995 && 0.9995 - state < 1e-15 * 4.0, "{state:?}");
    let set = [
        "run.section={ at = \"x[0] = 0.9995\" }",
        "run.record={ times = [0.33, 0.71], states = [\"x[0]\"] }",
    ];
    let (here, _) = works(VOLTERRA, &set);
    let crossed = rows(&here, "section.csv");
    assert_eq!(crossed.len(), 1, "{crossed:?}");
    assert!(
        (crossed[0][0] - stopped).abs() < 1e-12,
        "{crossed:?}, {stopped}"
    );
    let sampled = rows(&here, "samples.csv");
    let set = [
        "method={ stepper = \"rk4\", time-step = 0.01 }",
        "run.steps=33",
    ];
    let (_, told) = works(VOLTERRA, &set);
    let exact = told["final_state"][0].as_f64().expect("a coordinate");
    assert!(
        (sampled[1][0] - 0.33).abs() < 1e-15 && (sampled[1][1] - exact).abs() < 1e-9,
        "{sampled:?}, {exact}"
    );
}

#[test]
fn damping_and_noise_work() {
    let one_form = "method={ dynamics = \"one-form\", time-step = 0.05 }";
    for scene in [VOLTERRA, SPIRAL] {
        let (here, _) = works(scene, &[one_form, "system.damping={ rate = \"0.1\" }"]);
        let energies: Vec<f64> = rows(&here, "samples.csv")
            .iter()
            .map(|row| row[2])
            .collect();
        assert!(
            energies.windows(2).all(|pair| pair[1] < pair[0]),
            "{energies:?}"
        );
    }
    let noise = "system.noise=[{ hamiltonian = \"s.x[i]\", strength = 0.1 }]";
    let (_, told) = works(SPIRAL, &[noise, "run.seed=1"]);
    let state: Vec<f64> = told["final_state"]
        .as_array()
        .expect("a state")
        .iter()
        .filter_map(|x| x.as_f64())
        .collect();
    for i in 0..1000 {
        let square: f64 = [i, 1000 + i, 2000 + i]
            .iter()
            .map(|at| state[*at] * state[*at])
            .sum();
        assert!((square - 1.0).abs() < 1e-12, "{i}: {square}");
    }
    let noise = "system.noise=[{ hamiltonian = \"ln(x[i])\", strength = 0.1 }]";
    let (_, told) = works(VOLTERRA, &[noise, "run.seed=1", "method.noise=\"split\""]);
    let state = told["final_state"].as_array().expect("a state");
    assert!(state.iter().all(|x| x.as_f64().is_some_and(|x| x > 0.0)));
}

#[test]
fn the_rest_is_refused_in_words_of_mathematics() {
    // Up to 1024 coordinates are written out.
    let long = VOLTERRA.replace("x = 1000", "x = 1100");
    for (scene, site) in [(long.as_str(), "x[0]"), (SPIRAL, "s.x[0]")] {
        let record = |observable: &str| {
            format!(
                "run.record={{ every = 5, states = [\"{site}\"], observables = [\"{observable}\"] }}"
            )
        };
        for (set, because) in [
            (
                record("shadow-energy"),
                "its terms are brackets within brackets, each of which reaches farther sites",
            ),
            (
                format!("method.pace=\"2 + {site}\""),
                "every site is moved by the energy of all others",
            ),
        ] {
            let (_, said) = run(scene, &[&set]);
            assert_eq!(said.code, Some(3), "{set}: {}", said.err);
            said.says(&[because]);
        }
        // Vectors are carried by the derivative of every step, which no matrix holds.
        let (_, said) = run(scene, &[&record("megno")]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        said.says(&["MEGNO"]);
    }
    // Forces as they stand in x' = {H, x} − Π(η): the method that does not take them names those that do.
    let (_, said) = run(VOLTERRA, &["system.forces={ \"x[i]\" = \"0.1\" }"]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[
        "integrates only x' = {H, x}, and this system has forces",
        "one-form",
    ]);
}
