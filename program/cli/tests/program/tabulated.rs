//! Many steps of a scene put together into one, on the command line.

use super::support::Place;

/// A driven pendulum of small swings, whose period in time is π/2.
const DRIVEN: &str = "[system]\nvariables = [\"q\", \"p\"]\nparameters = { a = 0.02 }\nbracket = { \"q,p\" = 1 }\nconvention = \"{x,H}\"\n\
                      hamiltonian = \"p^2/2 - a*cos(q)*cos(4*t)\"\n\n[method]\nrealization = \"auto\"\n\
                      dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.04908738521234052\n\n\
                      [run]\ninitial = [0.3, 0.2]\nsteps = 320\nsection = { at = \"sin(2*t) = 0\", axes = [\"q\", \"p\"] }\n";

fn last(here: &Place, folder: &str) -> Vec<f64> {
    let samples = here.read(&format!("{folder}/samples.csv"));
    let names: Vec<&str> = samples.lines().next().expect("names").split(',').collect();
    let row: Vec<&str> = samples.lines().last().expect("rows").split(',').collect();
    let of = |name: &str| {
        let at = names.iter().position(|own| *own == name).expect(name);
        row[at].parse().expect("a number")
    };
    vec![of("q"), of("p")]
}

/// How much ten errors grow, one in each coordinate at the end of each period: a change of q' = p, p' = -a sin q cos 4t is no larger after a time s than
/// that of q'' = a q, cosh(√a s) + sinh(√a s)/√a times the first.
fn grown(count: u32, period: f64, a: f64) -> f64 {
    let root = libm::sqrt(a);
    let after = |k: u32| root * period * f64::from(k);
    let own = (0..count).map(|k| libm::cosh(after(k)) + libm::sinh(after(k)) / root);
    own.sum()
}

/// Ten periods by the table are those by 320 steps, to its errors and their growth: twice the largest that 200 states show. The scene has no time.
#[test]
fn a_period_is_one_step() {
    let here = Place::with(DRIVEN);
    let arguments = [
        "tabulate",
        "scene.toml",
        "--steps",
        "32",
        "--box",
        "q=0:6.283185307179586",
        "--box",
        "p=-1:1",
        "--basis",
        "q=fourier",
        "--degree",
        "q=5,p=7",
        "--set",
        "system.parameters.a=0.03",
        "--out",
        "table.toml",
        "--json",
    ];
    let said = here.leafwise(&arguments);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let report = said.json();
    assert_eq!(report["functions"], 87);
    assert_eq!(report["steps"], 32);
    let error = report["largest_error"].as_f64().expect("a number");
    assert!(error < 1e-6, "{report}");
    assert_eq!(report["method"]["steps"], 32);
    // Both runs with the parameter of the table.
    let set = "system.parameters.a=0.03";
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        set,
        "--out",
        "steps",
        "--quiet",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = here.leafwise(&["run", "table.toml", "--out", "table", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let (table, steps) = (last(&here, "table"), last(&here, "steps"));
    let most = grown(10, std::f64::consts::FRAC_PI_2, 0.03) * 2.0 * error;
    for (a, b) in table.iter().zip(&steps) {
        assert!((a - b).abs() < most, "{table:?} {steps:?} {most:e}");
    }
    let said = here.leafwise(&["check", "table.toml"]);
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
    // A file that exists stays.
    assert_eq!(here.leafwise(&arguments).code, Some(2));
}

/// A library's system, the box of its own orbit: of a rigid body one long step of the method is as good, and that is printed.
#[test]
fn longer_steps_as_good_as_the_table_are_printed() {
    let scene = "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 8 }\n\
                 time-step = 0.05\n[run]\ninitial = [0.3, 0.9, 0.4]\nsteps = 200\n";
    let here = Place::with(scene);
    let said = here.leafwise(&[
        "tabulate",
        "scene.toml",
        "--steps",
        "4",
        "--degree",
        "4",
        "--pairs",
        "200",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        said.out.contains("Table of 4 steps, a time of 0.2"),
        "{}",
        said.out
    );
    assert!(said.out.contains("1 longer ones"), "{}", said.out);
}

/// Half a turn of an oscillator, forces, noise, paces, boxes and degrees that are none.
#[test]
fn what_has_no_table_says_why() {
    let half = std::f64::consts::PI / 8.0;
    let oscillator = format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = 1 }}\nhamiltonian = \"(q^2 + p^2)/2\"\n\n[method]\nrealization = \"auto\"\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = 8 }}\ntime-step = {half:?}\n\n[run]\ninitial = [1, 0]\nsteps = 50\n"
    );
    let here = Place::with(&oscillator);
    here.write("states.csv", "q,w\n1,0\n");
    here.write(
        "forced.toml",
        &oscillator
            .replace("[method]", "[system.forces]\np = \"-p\"\n\n[method]")
            .replace("{ name = \"hamilton-jacobi\", order = 8 }", "\"one-form\""),
    );
    for (scene, arguments, expected) in [
        (
            "scene.toml",
            vec!["--degree", "2"],
            "8 steps have no generating function in the whole region",
        ),
        ("forced.toml", vec![], "a motion with forces"),
        ("scene.toml", vec!["--box", "w=0:1"], "no such variable"),
        ("scene.toml", vec!["--box", "q=1"], "no range"),
        (
            "scene.toml",
            vec!["--box", "q=1:0"],
            "q from 1.0 to 0.0 is not a range",
        ),
        ("scene.toml", vec!["--degree", "q=3"], "p has no degree"),
        ("scene.toml", vec!["--degree", "w=3"], "no variable `w`"),
        (
            "scene.toml",
            vec!["--degree", "many"],
            "`many` is no degree",
        ),
        (
            "scene.toml",
            vec!["--degree", "99"],
            "the degree 99 is outside 1 to 24",
        ),
        (
            "scene.toml",
            vec!["--states", "states.csv"],
            "no column `p`",
        ),
        (
            "scene.toml",
            vec!["--states", "none.csv"],
            "cannot read none.csv",
        ),
    ] {
        let all: Vec<&str> = ["tabulate", scene, "--steps", "8"]
            .into_iter()
            .chain(arguments)
            .collect();
        let said = here.leafwise(&all);
        assert_eq!(said.code, Some(2), "{expected}: {}", said.err);
        assert!(said.err.contains(expected), "{expected}: {}", said.err);
    }
}

const PENDULUM: &str = "[system]\nvariables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 - 0.5*cos(q)\"\n\n[method]\n\
                        realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.05\n\n\
                        [run]\ninitial = [0.6, 0]\nsteps = 300\n";

/// A table of 30 steps makes steps of their time alone, back too. What takes other steps refuses it in words, and no advice asks for others.
#[test]
fn a_table_holds_for_its_own_step() {
    let here = Place::with(PENDULUM);
    let said = here.leafwise(&[
        "tabulate",
        "scene.toml",
        "--steps",
        "30",
        "--degree",
        "8",
        "--box",
        "q=-1:1",
        "--box",
        "p=-0.8:0.8",
        "--out",
        "table.toml",
        "--json",
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let error = said.json()["largest_error"].as_f64().expect("a number");
    assert!(here.read("table.toml").contains("time-step = 1.5"));
    let said = here.leafwise(&["run", "table.toml", "--out", "table"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for text in [&said.out, &said.err] {
        assert!(!text.contains("time-step = "), "{text}");
    }
    // The same step backwards is the inverse map.
    let end = last(&here, "table");
    let back = [
        "run",
        "table.toml",
        "--set",
        "method.time-step=-1.5",
        "--set",
        &format!("run.initial={end:?}"),
        "--out",
        "back",
        "--quiet",
    ];
    let said = here.leafwise(&back);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let begin = last(&here, "back");
    // Ten solves to round-off each way, of a motion that grows slowly.
    for (a, b) in begin.iter().zip([0.6, 0.0]) {
        assert!((a - b).abs() < 1e-12, "{begin:?} {error:e}");
    }
    let said = here.leafwise(&[
        "run",
        "table.toml",
        "--set",
        "method.time-step=0.75",
        "--out",
        "half",
    ]);
    assert_eq!(said.code, Some(3), "{}", said.out);
    said.says(&[
        "holds for steps of 1.5 alone, and this one is 0.75",
        "write time-step = 1.5",
    ]);
    // Before a run begins, with a cure that is one.
    let check = |changes: &[&str]| {
        let changes = changes.iter().flat_map(|change| ["--set", change]);
        let arguments: Vec<&str> = ["check", "table.toml"].into_iter().chain(changes).collect();
        here.leafwise(&arguments)
    };
    for step in ["method.time-step=0.75", "method.time-step=-3"] {
        let said = check(&[step]);
        assert_eq!(said.code, Some(3), "{step}: {}", said.out);
        let sign = if step.contains('-') && step.contains("=-") {
            "-"
        } else {
            ""
        };
        said.says(&["alone", &format!("write time-step = {sign}1.5")]);
    }
    assert_eq!(check(&["method.time-step=-1.5"]).code, Some(0));
    let table = here.read("table.toml");
    let (head, run) = table.split_once("[run]").expect("a table");
    let until: Vec<&str> = run
        .lines()
        .map(|line| {
            if line.starts_with("steps") {
                "until = 10"
            } else {
                line
            }
        })
        .collect();
    here.write("until.toml", &format!("{head}[run]{}\n", until.join("\n")));
    let said = here.leafwise(&["check", "until.toml"]);
    assert_eq!(said.code, Some(3), "{}", said.out);
    said.says(&["is not a whole number of them", "write steps = 7"]);
    here.write(
        "until.toml",
        &here.read("until.toml").replace("until = 10", "steps = 7"),
    );
    assert_eq!(here.leafwise(&["check", "until.toml"]).code, Some(0));
    // Its declarations hold at its own step. An order is of steps that shorten.
    let said = here.leafwise(&["verify", "table.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
    // A crossing lies within a step.
    let cross = "run.section={ at = \"q = 0\" }";
    let said = here.leafwise(&["run", "table.toml", "--set", cross, "--out", "cross"]);
    assert_eq!(said.code, Some(1), "{}", said.out);
    said.says(&["holds for steps of 1.5 alone"]);
    for arguments in [
        &["orbit", "table.toml"][..],
        &["compare", "table.toml"],
        &["tune", "table.toml", "--error", "1e-6"],
        &["tune", "table.toml", "--shadow", "1e-6"],
    ] {
        let said = here.leafwise(arguments);
        assert_eq!(said.code, Some(2), "{arguments:?}: {}", said.out);
        said.says(&["the generating function holds for", "alone"]);
    }
    let said = here.leafwise(&["run", "table.toml", "--error", "--out", "error"]);
    said.says(&["the generating function holds for steps of 1.5 alone"]);
}

/// Steps over no period of the drive: cos 1.7 t turns by 1.36 in them.
#[test]
fn a_table_of_no_period_is_told() {
    let driven = PENDULUM
        .replace("0.5*cos(q)", "cos(q) + 0.3*q*cos(1.7*t)")
        .replace("0.05", "0.1");
    let here = Place::with(&driven);
    let box_of = ["--box", "q=-1:1", "--box", "p=-1:1", "--degree", "6"];
    let said = here.leafwise(&[&["tabulate", "scene.toml", "--steps", "8"][..], &box_of].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["the table holds only from t = 0", "8 steps from t = 0.8 on"]);
    // Whole periods do not.
    let whole = driven.replace(
        "0.1\n",
        &format!("{:?}\n", std::f64::consts::TAU / 1.7 / 16.0),
    );
    let here = Place::with(&whole);
    let own = [
        "--box",
        "q=-0.3:0.3",
        "--box",
        "p=-0.3:0.3",
        "--degree",
        "6",
    ];
    let said = here.leafwise(&[&["tabulate", "scene.toml", "--steps", "16"][..], &own].concat());
    assert!(
        !said.err.contains("the table holds only from"),
        "{}",
        said.err
    );
}

/// Numbers of pairs and states, ranges and degrees that stand twice, scenes without a table: what is wrong is named.
#[test]
fn counts_and_scenes_that_give_no_table() {
    let here = Place::with(PENDULUM);
    here.write("four.csv", "q,p\n0,0.1\n0.1,0.1\n0.2,0\n0.3,0\n");
    here.write(
        "contact.toml",
        "[system]\nvariables = [\"q\", \"p\", \"s\"]\nbracket = \"contact\"\nhamiltonian = \"p^2/2 - cos(q) + 0.1*s\"\n[method]\n\
         realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }\ntime-step = 0.1\n[run]\ninitial = [1, 0, 0]\nsteps = 10\n",
    );
    here.write(
        "exact.toml",
        "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }\n\
         time-step = 0.1\nenergy = \"exact\"\n[run]\ninitial = [0.3, 0.9, 0.4]\nsteps = 10\n",
    );
    for (arguments, told) in [
        (&["scene.toml", "--pairs", "0"][..], "0 is not in 1.."),
        (
            &["scene.toml", "--states", "four.csv"],
            "a table needs 5 states or more, of which every fifth measures its error, and these are 4",
        ),
        (
            &["scene.toml", "--states", "four.csv"],
            "`leafwise explain tabulate`",
        ),
        (
            &["scene.toml", "--pairs", "1", "--degree", "6"],
            "1 pair gives 2 equations",
        ),
        (
            &["scene.toml", "--box", "q=-1:1", "--box", "q=-2:2"],
            "q has a range already",
        ),
        (
            &["scene.toml", "--degree", "q=3,q=4"],
            "q has a degree already",
        ),
        (&["exact.toml"], "with energy = \"exact\" each step"),
        (
            &["contact.toml"],
            "the map of a contact bracket is not a Poisson map",
        ),
    ] {
        let said = here.leafwise(&[&["tabulate", "--steps", "4"][..], arguments].concat());
        assert_eq!(
            said.code,
            Some(2),
            "{arguments:?}: {}{}",
            said.out,
            said.err
        );
        said.says(&[told]);
        assert!(!said.err.contains("   "), "{}", said.err);
    }
    // Three steps are as good as one of three times the length too.
    let scene = "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 8 }\n\
                 time-step = 0.05\n[run]\ninitial = [0.3, 0.9, 0.4]\nsteps = 200\n";
    let here = Place::with(scene);
    let said = here.leafwise(&[
        "tabulate",
        "scene.toml",
        "--steps",
        "3",
        "--degree",
        "4",
        "--json",
    ]);
    assert_eq!(said.json()["as_good"]["steps"], 1, "{}", said.out);
}
