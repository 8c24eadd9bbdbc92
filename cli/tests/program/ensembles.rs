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
