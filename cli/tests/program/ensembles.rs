//! Ensembles from the command line.

use crate::support::{BODY, Place};

const ENSEMBLE: &str = "[ensemble]\nmembers = 30\ninitial = { ball = 0.1 }\n\
    record = { every = 20, quantiles = [0.5] }\nfinal-states = \"csv\"\n";

fn with(ensemble: &str) -> Place {
    Place::with(&format!("{BODY}{ensemble}"))
}

#[test]
fn an_ensemble_prints_its_object_and_tables() {
    let here = with(ENSEMBLE);
    let said = here.leafwise(&["ensemble", "scene.toml", "--json", "--threads", "2"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["outcome"], "done");
    assert_eq!((&json["members"], &json["failed"]), (&30.into(), &0.into()));
    let times: Vec<_> = json["statistics"]
        .as_array()
        .expect("a list")
        .iter()
        .collect();
    assert_eq!(times.len(), 3);
    assert_eq!(times[2]["time"], 4.0);
    let energy = &times[2]["energy"];
    assert!(
        energy["variance"].as_f64().is_some_and(|v| v > 0.0),
        "{energy}"
    );
    assert_eq!(energy["rank_error"], 0.0);
    assert_eq!(json["run_directory"], "runs/scene-ensemble");
    said.says(&[
        "30 members to t = 4",
        "at the end",
        "50%",
        "drift",
        "members a second",
    ]);
    for file in [
        "scene.toml",
        "manifest.json",
        "statistics.csv",
        "windows.csv",
        "report.html",
    ] {
        assert!(
            here.path("runs/scene-ensemble").join(file).exists(),
            "{file}"
        );
    }
    let again = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(again.code, Some(2));
    again.says(&["holds a run that has finished"]);
    let other = here.leafwise(&["run", "scene.toml", "--out", "runs/scene-ensemble"]);
    assert_eq!(other.code, Some(2));
    other.says(&["runs/scene-ensemble holds an ensemble"]);
}

#[test]
fn a_member_runs_alone_as_an_ordinary_run() {
    let here = with(ENSEMBLE);
    let said = here.leafwise(&["ensemble", "scene.toml", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let said = here.leafwise(&["ensemble", "scene.toml", "--member", "17", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    assert_eq!(json["run_directory"], "runs/scene-member-17");
    let state: Vec<String> = json["final_state"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|x| format!("{:?}", x.as_f64().expect("a number")))
        .collect();
    let states = here.read("runs/scene-ensemble/final_states.csv");
    let row = states.lines().nth(18).expect("a row");
    assert!(
        row.starts_with(&format!("17,done,{},", state.join(","))),
        "{row}"
    );
    // The scene it leaves behind is a scene of its own.
    let text = here.read("runs/scene-member-17/scene.toml");
    assert!(!text.contains("[ensemble]"), "{text}");
    let absent = here.leafwise(&["ensemble", "scene.toml", "--member", "30"]);
    assert_eq!(absent.code, Some(2));
    absent.says(&["there is no member 30: they are 0 to 29"]);
}

#[test]
fn what_is_wrong_with_the_table_is_underlined() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&["the scene has no [ensemble] table", "for example"]);
    let here = with("[ensemble]\nmembers = 30\ninitial = { bal = 0.1 }\n");
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&[
        "unknown key `bal` in initial",
        "did you mean `ball`?",
        "initial = { bal = 0.1 }",
    ]);
}

#[test]
fn a_table_of_states_is_read_by_name_and_refused_with_the_row_or_column_that_is_wrong() {
    let here = with("[ensemble]\ninitial = { file = \"states.csv\" }\n");
    let run = |table: &str| {
        here.write("states.csv", table);
        here.leafwise(&["ensemble", "scene.toml", "--json", "--force", "--quiet"])
    };
    for (table, piece) in [
        ("", "it has no row"),
        ("x1,x2,x3\n", "it has no row"),
        ("x1,x2,x3\n1,2,3\n1,2\n", "row 2 has 2 numbers"),
        ("x1,x2,x3\n1,2,3\n1,nan,3\n", "row 2 holds NaN"),
        ("x1,x2,x3\n1,2,inf\n", "row 1 holds inf"),
        ("x1,x2,x3\n1,2,1e999\n", "row 1 holds inf"),
        ("x1,x2,x3\n1,2,a\n", "line 2 is not a row of numbers"),
        (
            "x1,x2,x4\n1,2,3\n",
            "column `x4` is none of the coordinates x1, x2, x3",
        ),
        ("x1,x2\n1,2\n", "no column `x3`"),
        ("x1,x2,x2\n1,2,3\n", "two columns `x2`"),
        ("x1,x2,x3,I2\n1,2,3,0.7\n", "column `I2` is none"),
    ] {
        let said = run(table);
        assert_eq!(said.code, Some(3), "{table}: {}", said.err);
        said.says(&["states.csv", piece]);
    }
    std::fs::remove_file(here.path("states.csv")).expect("a file");
    let said = here.leafwise(&["ensemble", "scene.toml"]);
    assert_eq!(said.code, Some(3));
    said.says(&["cannot read states.csv"]);
    // The order of the columns is the file's.
    let of_order = |table: &str| {
        let said = run(table);
        assert_eq!(said.code, Some(0), "{}", said.err);
        said.json()["statistics"].clone()
    };
    assert_eq!(of_order("x3,x1,x2\n3,1,2\n"), of_order("x1,x2,x3\n1,2,3\n"));
    assert_ne!(of_order("x3,x1,x2\n3,1,2\n"), of_order("3,1,2\n"));
}

/// The method of an ensemble is judged at its members' states.
#[test]
fn an_ensemble_is_warned_as_a_run_is() {
    let here = with(ENSEMBLE);
    let warned = |method: &[&str], out: &str| {
        let command = ["ensemble", "scene.toml", "--json", "--out", out];
        let said = here.leafwise(&[&command[..], method].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        let kinds = said.json()["warnings"].as_array().expect("a list").clone();
        let kinds: Vec<String> = kinds
            .iter()
            .filter_map(|one| Some(one["kind"].as_str()?.to_owned()))
            .collect();
        assert_eq!(
            said.err.matches("warning").count(),
            kinds.len(),
            "{}",
            said.err
        );
        kinds
    };
    let long = [
        "--set",
        "method.realization.order=14",
        "--set",
        "method.time-step=0.01",
    ];
    assert_eq!(warned(&long, "long"), ["truncation-order"]);
    let good = ["--set", "method.realization=auto"];
    assert_eq!(warned(&good, "good"), Vec::<String>::new());
    // At the members' states, which are not the scene's: there the chart is nearly used up.
    here.write(
        "scene.toml",
        &format!("{BODY}[ensemble]\ninitial = {{ file = \"states.csv\" }}\n").replace(
            "{ name = \"karasev-truncated\", order = 4 }",
            "\"so3-exponential\"",
        ),
    );
    here.write("states.csv", "4,0,0\n");
    let step = ["--set", "method.time-step=1.3"];
    let kinds = warned(&step, "large");
    assert!(kinds.contains(&"chart".to_owned()), "{kinds:?}");
}

#[test]
fn members_that_are_not_there_are_refused() {
    let here = with(ENSEMBLE);
    let refused = |arguments: &[&str], code: i32, piece: &str| {
        let said = here.leafwise(&[&["ensemble", "scene.toml"][..], arguments].concat());
        assert_eq!(said.code, Some(code), "{arguments:?}: {}", said.err);
        said.says(&[piece]);
    };
    refused(
        &["--member", "30"],
        2,
        "there is no member 30: they are 0 to 29",
    );
    for member in ["-1", "1.5", "nan", "99999999999999999999"] {
        refused(&["--member", member], 2, "--member");
    }
    for count in ["0", "-3", "1.5", "nan", "1e30"] {
        refused(
            &["--set", &format!("ensemble.members={count}")],
            3,
            "must be a whole number",
        );
    }
    refused(&["--threads", "0"], 2, "--threads");
    refused(&["--lanes", "0"], 2, "--lanes");
    assert!(here.is_untouched());
}
