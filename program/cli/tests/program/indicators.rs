//! Indicators of chaos: columns of runs, ensembles and sweeps, what is said of them, where they are refused.

use crate::support::{BODY, Place, Said};

const RECORD: &str = "run.record.observables=[\"megno\", \"lyapunov\", \"sali\"]";

fn run(here: &Place, set: &[&str]) -> Said {
    let mut arguments = vec!["run", "scene.toml", "--json", "--force"];
    set.iter().for_each(|set| arguments.extend(["--set", set]));
    here.leafwise(&arguments)
}

#[test]
fn a_run_says_whether_it_is_regular() {
    let here = Place::with(BODY);
    let said = run(&here, &["run.steps=20000", "run.record.every=100", RECORD]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["motion   regular: MEGNO", "an e-folding time below"]);
    let json = said.json();
    assert_eq!(json["chaos"]["motion"], "regular");
    let megno = json["chaos"]["megno"].as_f64().expect("a number");
    assert!((megno - 2.0).abs() < 0.2, "{megno}");
    let rows = here.read("runs/scene/samples.csv");
    assert!(
        rows.lines()
            .next()
            .is_some_and(|line| line.ends_with("megno,lyapunov,sali")),
        "{rows}"
    );
    let short = run(&here, &["run.steps=20", RECORD]);
    short.says(&["motion   not yet known: MEGNO", "take more steps"]);
    assert_eq!(short.json()["chaos"]["motion"], "not-yet-known");
}

/// The columns of members, alone and together, on any threads and in shards, and of a sweep's settings.
#[test]
fn members_and_settings_have_the_indicators_of_runs() {
    let ensemble = "[ensemble]\nmembers = 9\ninitial = { ball = 0.1 }\n\
        record = { every = 20, observables = [\"sali\", \"megno\"] }\nfinal-states = \"csv\"\n";
    let here = Place::with(&format!("{BODY}{ensemble}"));
    let mut tables = Vec::new();
    for (out, extra) in [("one", "1"), ("two", "2")] {
        let said = here.leafwise(&[
            "ensemble",
            "scene.toml",
            "--out",
            out,
            "--threads",
            extra,
            "--lanes",
            extra,
        ]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        tables.push(here.read(&format!("{out}/final_states.csv")));
        tables.push(here.read(&format!("{out}/statistics.csv")));
    }
    assert_eq!(tables[..2], tables[2..]);
    let said = here.leafwise(&[
        "ensemble",
        "scene.toml",
        "--member",
        "7",
        "--json",
        "--set",
        RECORD,
    ]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let alone = here.read("runs/scene-member-7/samples.csv");
    let alone: Vec<&str> = alone.lines().last().expect("a row").split(',').collect();
    let row = tables[0].lines().nth(8).expect("a row");
    let pair = format!(",{},{},", alone[6], alone[4]);
    assert!(row.contains(&pair), "{pair} in {row}");

    let sweep = "[sweep]\ngrid = { \"system.parameters.I2\" = [0.7, 0.8] }\n";
    let here = Place::with(&format!("{BODY}{sweep}"));
    let record = RECORD.replace("run.record", "sweep.record");
    let said = here.leafwise(&["sweep", "scene.toml", "--set", &record]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let table = here.read("runs/scene-sweep/sweep.csv");
    let said = run(&here, &["system.parameters.I2=0.8", RECORD]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let alone = here.read("runs/scene/samples.csv");
    let alone: Vec<&str> = alone.lines().last().expect("a row").split(',').collect();
    let row = table.lines().nth(2).expect("a row");
    assert!(row.contains(&alone[4..].join(",")), "{alone:?} in {row}");
}

#[test]
fn they_are_refused_where_steps_have_no_tangent() {
    let here = Place::with(BODY);
    for (set, pieces) in [
        (
            vec!["method={ stepper = \"dop853\", time-step = 0.1 }", RECORD],
            [
                "follows the exact tangent of each step",
                "take hamilton-jacobi",
            ],
        ),
        (
            vec!["run.record.observables=[\"lyapunov 0\"]"],
            ["`lyapunov 0` is not an indicator of chaos", "`lyapunov 2`"],
        ),
        (
            vec!["run.record.observables=[\"lyapunov 1.5\"]"],
            [
                "`lyapunov 1.5` is not an indicator of chaos",
                "`lyapunov 2`",
            ],
        ),
        (
            vec!["run.record.observables=[\"sali 2\"]"],
            ["`sali 2` is not an indicator of chaos", "write `megno`"],
        ),
        (
            vec!["run.record.observables=[\"lyapunv\"]"],
            ["unknown observable `lyapunv`", "did you mean `lyapunov`?"],
        ),
        (
            vec![
                "system.noise=[{ hamiltonian = \"x1\", strength = 0.1 }]",
                "run.seed=1",
                RECORD,
            ],
            ["is not offered with noise", "remove the noise"],
        ),
    ] {
        let said = run(&here, &set);
        assert_eq!(said.code, Some(3), "{set:?} {}", said.err);
        said.says(&pieces);
    }
    // so(3)* has three directions.
    let said = run(&here, &["run.record.observables=[\"lyapunov 4\"]"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    said.says(&[
        "too few directions for the Lyapunov exponents up to the last",
        "record fewer exponents: as many as coordinates",
    ]);
    let said = run(&here, &["run.record.observables=[\"lyapunov 3\"]"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
}
