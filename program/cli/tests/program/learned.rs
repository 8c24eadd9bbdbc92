//! Maps learned from files of pairs, on the command line.

use super::support::Place;

/// A rigid body, stepped by a Hamilton–Jacobi method of order 10.
const BODY: &str = "[system]\nvariables = [\"x\", \"y\", \"z\"]\nbracket = { \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }\n\
                    hamiltonian = \"x^2/2 + 2*y^2/3 + 0.4*z^2\"\ncasimirs = { C = \"x^2 + y^2 + z^2\" }\n\n[method]\nrealization = \"auto\"\n\
                    dynamics = { name = \"hamilton-jacobi\", order = 10 }\ntime-step = 0.1\n\n[run]\ninitial = [1, 0.2, 0.1]\nsteps = 40\n\
                    record = { observables = [\"energy\", \"C\"] }\n";

/// Samples of runs from three states, one below the other.
fn trajectories(here: &Place) -> String {
    let mut rows = String::new();
    for (at, initial) in ["[1, 0.2, 0.1]", "[0.2, 0.3, 1.1]", "[-0.4, 0.9, 0.3]"]
        .iter()
        .enumerate()
    {
        let (set, out) = (format!("run.initial={initial}"), format!("run{at}"));
        let said = here.leafwise(&["run", "scene.toml", "--set", &set, "--out", &out, "--quiet"]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read(&format!("{out}/samples.csv"));
        let lines = samples.lines().skip(usize::from(at > 0));
        lines.for_each(|line| rows.push_str(&format!("{line}\n")));
    }
    rows
}

/// The samples of runs are pairs: the scene that is written steps as they do, and keeps the Casimir.
#[test]
fn a_scene_is_learned_from_samples_of_runs() {
    let here = Place::with(BODY);
    here.write("pairs.csv", &trajectories(&here));
    let arguments = [
        "learn",
        "scene.toml",
        "pairs.csv",
        "--degree",
        "4",
        "--out",
        "learned.toml",
    ];
    let said = here.leafwise(&arguments);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        said.out.contains("34 functions") && said.out.contains("from 120 pairs"),
        "{}",
        said.out
    );
    let said = here.leafwise(&["run", "learned.toml", "--out", "a", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let column = |text: &str, name: &str| -> Vec<f64> {
        let at = text
            .lines()
            .next()
            .and_then(|names| names.split(',').position(|own| own == name));
        let rows = text
            .lines()
            .skip(1)
            .map(|row| row.split(',').nth(at.expect(name)).map(str::parse::<f64>));
        rows.map(|cell| cell.expect(name).expect("a number"))
            .collect()
    };
    let (learned, truth) = (here.read("a/samples.csv"), here.read("run0/samples.csv"));
    for name in ["x", "y", "z"] {
        let errors = column(&learned, name)
            .into_iter()
            .zip(column(&truth, name))
            .map(|(a, b)| (a - b).abs());
        // The fit leaves 1e-8 a step at this degree, over 40 steps.
        assert!(errors.fold(0.0, f64::max) < 1e-5);
    }
    let casimir = column(&learned, "C");
    assert!(casimir.iter().all(|c| (c - casimir[0]).abs() < 1e-14));
    // A file that exists stays.
    let said = here.leafwise(&arguments);
    assert_eq!(said.code, Some(2), "{}", said.err);
}

/// A library's system is written out with the values of its parameters; logarithms stand beside where the bracket is log-canonical.
#[test]
fn a_library_system_is_learned() {
    let scene = "[system]\nlibrary = \"lotka-volterra-periodic\"\n[method]\nrealization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 8 }\n\
                 time-step = 0.05\n[run]\ninitial = [1, 1.9, 0.5]\nsteps = 60\n";
    let here = Place::with(scene);
    let said = here.leafwise(&["run", "scene.toml", "--out", "run0", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = here.leafwise(&[
        "learn",
        "scene.toml",
        "run0/samples.csv",
        "--degree",
        "1",
        "--out",
        "learned.toml",
        "--json",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let report = said.json();
    let functions = report["functions"].as_array().expect("a list");
    assert_eq!(functions.len(), 6, "{report}");
    let said = here.leafwise(&["check", "learned.toml"]);
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
}

/// Files and options that do not fit say what to do.
#[test]
fn what_is_no_pair_says_why() {
    let here = Place::with(BODY);
    here.write(
        "few.csv",
        "x,y,z,x',y',z'\n1,0,0,0.9,0.1,0\n0,1,0,0.1,0.9,0\n",
    );
    here.write("columns.csv", "x,y,w\n1,0,0\n0,1,0\n");
    here.write("far.csv", "t,x,y,z\n0,1,0,0\n1,0,1,0\n");
    here.write("nan.csv", "x,y,z\n1,0,0\n0,nan,0\n1,0,1\n");
    for (arguments, expected) in [
        (
            vec!["few.csv", "--degree", "2"],
            "2 pairs give 4 equations for 9 coefficients",
        ),
        (vec!["columns.csv"], "it has no column `z`"),
        (vec!["far.csv"], "--set method.time-step=1.0"),
        (vec!["nan.csv"], "pair 2 holds NaN before the step"),
        (vec!["few.csv", "--basis", "w=fourier"], "no variable `w`"),
        (vec!["few.csv", "--basis", "splines"], "is not a basis"),
        (vec!["none.csv"], "cannot read none.csv"),
    ] {
        let all: Vec<&str> = ["learn", "scene.toml"]
            .into_iter()
            .chain(arguments)
            .collect();
        let said = here.leafwise(&all);
        assert_eq!(said.code, Some(2), "{}", said.err);
        assert!(said.err.contains(expected), "{expected}: {}", said.err);
    }
}

/// Pairs of another motion: exit code 5, and the scene is written nevertheless.
#[test]
fn a_motion_that_no_hamiltonian_makes_is_told() {
    let here = Place::with(BODY);
    let mut rows = "x,y,z,x',y',z'\n".to_owned();
    for k in 0..60 {
        // All shrink to 0.
        let at = f64::from(k);
        let x = [
            1.0 + 0.01 * at,
            0.3 - 0.02 * at,
            0.2 + 0.013 * at * at / 60.0,
        ];
        let row: Vec<String> = x
            .iter()
            .chain(&x.map(|x| 0.9 * x))
            .map(|x| format!("{x:?}"))
            .collect();
        rows.push_str(&format!("{}\n", row.join(",")));
    }
    here.write("pairs.csv", &rows);
    let said = here.leafwise(&["learn", "scene.toml", "pairs.csv", "--degree", "2"]);
    assert_eq!(said.code, Some(5), "{}{}", said.out, said.err);
    assert!(
        said.err.contains("leave their leaves") || said.err.contains("of the motion is not fitted"),
        "{}",
        said.err
    );
}
