//! Many settings of a scene, as one table, in shards and after interruptions.

use std::fs::OpenOptions;
use std::process::Stdio;

use crate::support::{BODY, Place, Said, catches, wait_for};

/// 3 × 2 × 2 settings: a parameter, the step, and the order of a part.
const GRID: &str = r#"[sweep]
grid = { "system.parameters.I2" = { range = [0.5, 1.5, 3] }, "method.time-step" = [0.05, 0.1], "method.realization.order" = [2, 4] }
record = { observables = ["energy", "x1", { late = "x2^2" }] }
"#;

fn place() -> Place {
    Place::with(&format!("{BODY}{GRID}"))
}

fn sweep(here: &Place, asked: &[&str]) -> Said {
    let mut arguments = vec!["sweep", "scene.toml"];
    arguments.extend(asked);
    here.leafwise(&arguments)
}

fn cells(row: &str) -> Vec<&str> {
    row.split(',').collect()
}

#[test]
fn a_row_is_the_run_of_its_setting_to_the_bit() {
    let here = place();
    let said = sweep(&here, &["--out", "out", "--json", "--quiet"]).json();
    assert_eq!(said["settings"], 12);
    assert_eq!(said["failed"], 0);
    assert_eq!(
        said["columns"]["drifts"],
        serde_json::json!(["energy_drift", "spin_drift"])
    );
    let table = here.read("out/sweep.csv");
    let mut rows = table.lines();
    assert_eq!(
        rows.next(),
        Some(
            "setting,system.parameters.I2,method.time-step,method.realization.order,outcome,error,t,energy_drift,spin_drift,\
             energy,x1,late,steps,evaluations,operations"
        )
    );
    let rows: Vec<Vec<&str>> = rows.map(cells).collect();
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let overrides: Vec<String> = [
            format!("system.parameters.I2={}", row[1]),
            format!("method.time-step={}", row[2]),
            format!("method.realization.order={}", row[3]),
            // The parts of all settings chose what they are made of at the scene's own values.
            "method.chosen-at.I2=0.75".to_owned(),
            "run.record.observables=[\"energy\"]".to_owned(),
        ]
        .into();
        let mut run = vec![
            "run",
            "scene.toml",
            "--out",
            "one",
            "--force",
            "--json",
            "--quiet",
        ];
        run.extend(overrides.iter().flat_map(|one| ["--set", one]));
        let one = here.leafwise(&run).json();
        let number = |cell: &str| -> f64 { cell.parse().expect("a number") };
        assert_eq!(one["outcome"], row[4]);
        assert_eq!(one["time"], number(row[6]));
        assert_eq!(one["drift"]["energy"], number(row[7]), "{row:?}");
        assert_eq!(one["drift"]["spin"], number(row[8]), "{row:?}");
        assert_eq!(one["final_state"][0], number(row[10]), "{row:?}");
        assert_eq!(row[12], "40");
        let of_a_step = one["solver"]["operations_per_step"]
            .as_f64()
            .expect("a number");
        assert_eq!(of_a_step, number(row[14]) / 40.0, "{row:?}");
    }
}

#[test]
fn shards_in_any_order_are_merged_to_the_bytes_of_one_process() {
    let here = place();
    let whole = sweep(&here, &["--out", "whole", "--quiet", "--threads", "1"]);
    assert_eq!(whole.code, Some(0), "{}", whole.err);
    let threads = sweep(&here, &["--out", "threads", "--quiet", "--threads", "3"]);
    assert_eq!(threads.code, Some(0), "{}", threads.err);
    for task in ["4", "1", "5"] {
        let said = sweep(&here, &["--out", "shards", "--shard", &format!("{task}/5")]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
    let missing = here.leafwise(&["merge", "shards", "--out", "merged"]);
    assert_eq!(missing.code, Some(5), "{}", missing.err);
    missing.says(&[
        "settings are missing: 2 to 6",
        "--array=2-3 with --shard slurm/5",
    ]);
    assert!(!here.path("merged").exists());
    for task in ["3", "2"] {
        let mut command = here.command(&[
            "sweep",
            "scene.toml",
            "--out",
            "shards",
            "--shard",
            "slurm/5",
        ]);
        command.env("SLURM_ARRAY_TASK_ID", task);
        let said = Said::from(command.output().expect("a task"));
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
    let again = sweep(&here, &["--out", "shards", "--shard", "2/5"]);
    again.says(&["nothing was computed"]);
    let merged = here.leafwise(&["merge", "shards", "--out", "merged", "--json"]);
    assert_eq!(merged.code, Some(0), "{}", merged.err);
    assert_eq!(merged.json()["done"], 12);
    for other in ["threads", "merged"] {
        for file in ["sweep.csv", "scene.toml"] {
            let [a, b] = ["whole", other].map(|of| here.read(&format!("{of}/{file}")));
            assert!(a == b, "{file} of {other} differs");
        }
    }
}

#[test]
fn a_terminated_sweep_goes_on_to_the_same_bytes() {
    let text = format!("{BODY}{GRID}").replace("steps   = 40", "steps   = 150000");
    let here = Place::with(&text);
    let whole = sweep(&here, &["--out", "whole", "--quiet"]);
    assert_eq!(whole.code, Some(0), "{}", whole.err);
    for (signal, number) in [("TERM", 15), ("USR1", 10)] {
        let mut child = here
            .command(&[
                "sweep",
                "scene.toml",
                "--out",
                "pieces",
                "--quiet",
                "--threads",
                "1",
            ])
            .stderr(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a start");
        // The manifest says so before the first row, and is replaced when the sweep is interrupted, but where that is
        // before it watches for signals: then this one is older than the program.
        let id = child.id();
        let file = here.path("pieces/manifest.json");
        let is_running = || {
            let text = std::fs::read_to_string(&file).unwrap_or_default();
            text.contains("\"outcome\": \"running\"") && catches(id, number)
        };
        wait_for(&mut child, is_running, "the first row");
        let kill = std::process::Command::new("kill")
            .args([format!("-{signal}"), child.id().to_string()])
            .status();
        assert!(kill.expect("kill").success());
        let said = Said::from(child.wait_with_output().expect("an end"));
        assert!(
            matches!(said.code, Some(130 | 0)),
            "{:?} {}",
            said.code,
            said.err
        );
    }
    let rest = sweep(&here, &["--out", "pieces", "--quiet"]);
    assert_eq!(rest.code, Some(0), "{}", rest.err);
    assert!(here.read("whole/sweep.csv") == here.read("pieces/sweep.csv"));
}

#[test]
fn a_setting_that_fails_is_a_row() {
    let steps =
        |values: &str| format!("{BODY}[sweep]\ngrid = {{ \"method.time-step\" = {values} }}\n");
    let here = Place::with(&steps("[0.1, 1e6]"));
    let said = sweep(&here, &["--out", "out"]);
    assert_eq!(said.code, Some(6), "{}", said.err);
    said.says(&["1 of 2 settings failed"]);
    let again = sweep(&here, &["--out", "out", "--quiet"]);
    assert_eq!(again.code, Some(6), "{}", again.err);
    again.says(&["1 of 2 settings failed"]);
    let shard = sweep(&here, &["--out", "parts", "--shard", "1/1"]);
    assert_eq!(shard.code, Some(0), "{}", shard.err);
    let merged = here.leafwise(&["merge", "parts", "--out", "whole"]);
    assert_eq!(merged.code, Some(6), "{}", merged.err);
    let table = here.read("out/sweep.csv");
    let row = table.lines().nth(2).expect("a row");
    assert!(row.starts_with("1,1e6,failed,"), "{row}");
    assert!(row.contains("step 1: "), "{row}");
    assert!(here.read("out/report.html").contains("Failed settings"));
    // As an ensemble of members that all fail.
    let here = Place::with(&steps("[1e6, 1e7]"));
    let said = sweep(&here, &["--out", "out"]);
    assert_eq!(said.code, Some(1), "{}", said.err);
    assert_eq!(here.read("out/sweep.csv").lines().count(), 3);
}

/// A paced run fails where its pace comes near to 0: the row is that of the state before.
#[test]
fn a_paced_setting_that_fails_has_its_own_last_state() {
    let here = Place::with(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
         hamiltonian = \"p^2/2 + q^2/2\"\n[method]\nrealization = \"auto\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\npace = \"q\"\ntime-step = 0.1\n\
         [run]\ninitial = [1, 0.2]\nsteps = 200\n\
         [sweep]\ngrid = { \"run.steps\" = [5, 200] }\nrecord = { observables = [\"q\", \"p\"] }\n",
    );
    sweep(&here, &["--out", "out", "--quiet"]);
    let table = here.read("out/sweep.csv");
    let failed = table.lines().nth(2).expect("two settings");
    let run = here.leafwise(&["run", "scene.toml", "--json", "--out", "run", "--quiet"]);
    let last = run.json()["final_state"].clone();
    let last: Vec<f64> = serde_json::from_value(last).expect("two numbers");
    let expected = format!(",{:?},{:?},", last[0], last[1]);
    assert!(failed.contains(&expected), "{failed}\n{expected}");
    // At every step it is a sample once.
    here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "run.record={every=1}",
        "--out",
        "every",
        "--quiet",
    ]);
    let samples = here.read("every/samples.csv");
    let times: Vec<&str> = samples.lines().skip(1).map(|row| cells(row)[0]).collect();
    assert!(times.windows(2).all(|pair| pair[0] != pair[1]), "{samples}");
}

#[test]
fn methods_and_files_of_settings() {
    let here = Place::with(&format!(
        "{BODY}[sweep]\nlist = [\n  {{ \"method.stepper\" = \"rk4\" }},\n  {{ \"method.realization\" = \"so3-group\", \
         \"run.initial\" = [3, 1, 3] }},\n  {{ \"run.steps\" = 7 }},\n]\n"
    ));
    let said = sweep(&here, &["--out", "list", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let list = here.read("list/sweep.csv");
    let head: Vec<String> = list.lines().map(|row| cells(row)[..4].join(",")).collect();
    assert_eq!(
        head[0],
        "setting,method.stepper,method.realization,run.initial"
    );
    assert_eq!(head[1], "0,rk4,,");
    assert!(
        list.lines().nth(3).expect("a row").contains(",7,done,"),
        "{list}"
    );
    // The same by a file: the table's own columns of settings.
    let scene = format!("{BODY}[sweep]\nfile = \"settings.csv\"\n");
    here.write("scene.toml", &scene);
    here.write(
        "settings.csv",
        "method.stepper,method.realization,run.initial,run.steps\nrk4,,,\n,so3-group,\"[3, 1, 3]\",\n,,,7\n",
    );
    let said = sweep(&here, &["--out", "file", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert_eq!(list, here.read("file/sweep.csv"));
    let shard = sweep(&here, &["--out", "parts", "--quiet", "--shard", "1/1"]);
    assert_eq!(shard.code, Some(0), "{}", shard.err);
    let merged = here.leafwise(&[
        "merge",
        "parts",
        "--out",
        "joined",
        "--scene",
        "scene.toml",
        "--quiet",
    ]);
    assert_eq!(merged.code, Some(0), "{}", merged.err);
    assert_eq!(list, here.read("joined/sweep.csv"));
    // A changed file is no continuation.
    here.write("settings.csv", "run.steps\n7\n");
    let said = sweep(&here, &["--out", "file"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["other numbers in settings.csv"]);
}

#[test]
fn what_is_no_sweep_is_refused_where_it_stands() {
    for (sweep_table, said) in [
        (
            "grid = { \"system.parameters.I9\" = [1] }",
            "unknown parameter `I9`",
        ),
        (
            "grid = { \"method.time-stepp\" = [1] }",
            "unknown key `time-stepp`",
        ),
        (
            "grid = { \"sweep.grid\" = [1] }",
            "a sweep has no sweep in it",
        ),
        (
            "grid = { \"ensemble.seed\" = [1] }",
            "`ensemble.seed` is not a key of settings",
        ),
        (
            "grid = { \"run.record.every\" = [1] }",
            "all settings have the same columns",
        ),
        (
            "grid = { \"run.out\" = [\"a\"] }",
            "write `out` into [sweep]",
        ),
        (
            "grid = { \"plugins\" = [[]] }",
            "all settings share their plugins",
        ),
        ("grid = { \"run.steps\" = [] }", "no value"),
        ("grid = {}", "0 settings"),
        ("list = []", "0 settings"),
        (
            "grid = { \"method.time-step\" = [0.1, nan] }",
            "finite number",
        ),
        (
            "grid = { \"method.time-step\" = [0.1, 0] }",
            "setting 1 of the sweep",
        ),
        (
            "grid = { \"method.time-step\" = { range = [0, 1, 1] } }",
            "count a whole number from 2",
        ),
        (
            "grid = { \"method.time-step\" = { logarithmic = [0, 1, 9] } }",
            "positive ends",
        ),
        (
            "grid = { \"method.time-step\" = { range = [1, 2, 10000] }, \"system.parameters.I2\" = { range = [1, 2, 10000] } }",
            "100000000 settings",
        ),
        (
            "grid = { \"method.time-step\" = [1], \"method.epsilon\" = [1] }",
            "cannot be combined with",
        ),
        (
            "list = [{ \"run.initial\" = [1, 2, 3], \"run.initial.x1\" = 1 }]",
            "cannot be combined with",
        ),
        ("grid = { \"method\" = [1] }", "`method` is a table"),
        (
            "grid = { \"run.initial\" = [[1, 2]] }",
            "setting 0 of the sweep",
        ),
        (
            "grid = { \"method.realization\" = [\"so3-group\", \"so4\"] }",
            "setting 1 of the sweep",
        ),
        (
            "grid = { \"run.steps\" = [1] }\nlist = []",
            "keep one of grid, list, file",
        ),
        (
            "grid = { \"method.dynamics.order\" = [2, 4], \"method.dynamics\" = [\"hamilton-jacobi\"] }",
            "`method.dynamics` replaces all keys within it: name it first",
        ),
        (
            "grid = { 'system.\"parameters\".I2' = [1] }",
            "write `system.parameters.I2`",
        ),
        ("file = \"none.csv\"", "none.csv"),
        ("", "grid"),
    ] {
        let here = Place::with(&format!("{BODY}[sweep]\n{sweep_table}\n"));
        let refused = sweep(&here, &["--out", "out"]);
        assert_eq!(refused.code, Some(3), "{sweep_table}\n{}", refused.err);
        assert!(refused.err.contains(said), "{said}\n{}", refused.err);
        assert!(here.is_untouched());
    }
    let without = Place::with(BODY);
    let refused = sweep(&without, &[]);
    assert_eq!(refused.code, Some(3));
    refused.says(&["the scene has no [sweep] table"]);
    let here = Place::with(&format!("{BODY}[sweep]\nfile = \"settings.csv\"\n"));
    for (text, said) in [
        ("", "it is empty"),
        ("run.steps\n", "no row"),
        ("run.stepps\n1\n", "unknown key `stepps`"),
        ("run.steps,run.steps\n1,2\n", "two columns"),
        (
            "run.steps, method.time-step\n1,2\n",
            "write `method.time-step`",
        ),
        (
            "method.dynamics.order,method.dynamics\n2,\"\"\"hamilton-jacobi\"\"\"\n",
            "name it first",
        ),
        ("run.steps\n1,2\n", "row 2 has 2 values"),
        ("method.time-step\nnan\n", "not a finite number"),
        ("run.steps\n\"1\n", "not closed"),
        ("method.time-step\nfast\n", "setting 0 of the sweep"),
    ] {
        here.write("settings.csv", text);
        let refused = sweep(&here, &["--out", "out"]);
        assert_eq!(refused.code, Some(3), "{text}\n{}", refused.err);
        assert!(refused.err.contains(said), "{said}\n{}", refused.err);
    }
}

#[test]
fn shards_that_do_not_fit_are_refused_by_name() {
    let here = place();
    for (asked, said) in [
        ("4/3", "shards are counted from 1 to 3"),
        ("0/3", "shards are counted from 1 to 3"),
        ("three", "`three` is not a shard"),
    ] {
        let refused = sweep(&here, &["--shard", asked]);
        assert_eq!(refused.code, Some(2), "{}", refused.err);
        assert!(refused.err.contains(said), "{said}\n{}", refused.err);
    }
    for shard in ["1/2", "2/2"] {
        let said = sweep(&here, &["--out", "shards", "--quiet", "--shard", shard]);
        assert_eq!(said.code, Some(0), "{}", said.err);
    }
    // Another scene, into the directory of a shard and beside it.
    let other = ["--set", "run.steps=7", "--shard", "2/2", "--out"];
    let refused = sweep(&here, &[other.as_slice(), &["shards"]].concat());
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["run.steps: 40 → 7"]);
    let said = sweep(&here, &[other.as_slice(), &["others", "--quiet"]].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    let refused = here.leafwise(&["merge", "shards/shard-1-of-2", "others", "--out", "merged"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["are not of one sweep", "run.steps: 40 → 7"]);
    // The same settings twice.
    let said = sweep(&here, &["--out", "again", "--quiet", "--shard", "1/2"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let refused = here.leafwise(&["merge", "shards", "again", "--out", "merged"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["hold the same settings, 0 to 5"]);
    // A directory that another program writes to.
    let lock = OpenOptions::new()
        .write(true)
        .open(here.path("shards/shard-1-of-2/.lock"))
        .expect("the lock");
    lock.lock().expect("a lock");
    let refused = sweep(&here, &["--out", "shards", "--shard", "1/2"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["another program is writing"]);
    drop(lock);
    // A table that was cut short.
    let name = "shards/shard-2-of-2/sweep.csv";
    let table = here.read(name);
    here.write(name, &table[..table.len() - 9]);
    let refused = here.leafwise(&["merge", "shards", "--out", "merged"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&[
        "sweep.csv is damaged",
        "make that shard again with --force",
        "bytes where the checkpoint counts",
    ]);
    // A manifest that was cut short: its settings are not missing.
    here.write(name, &table);
    let name = "shards/shard-2-of-2/manifest.json";
    let manifest = here.read(name);
    here.write(name, &manifest[..manifest.len() - 5]);
    let refused = here.leafwise(&["merge", "shards", "--out", "merged"]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    refused.says(&["shard-2-of-2/manifest.json is damaged"]);
}
