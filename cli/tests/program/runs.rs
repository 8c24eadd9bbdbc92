//! Runs from the command line: objects, directories, interruption and resumption.

use std::io::Read;
use std::process::{Child, Stdio};

use crate::support::{BODY, Place, gallery, wait_for};

#[test]
fn a_run_prints_the_fixed_names_and_a_table() {
    let here = Place::with(BODY);
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let json = said.json();
    let names: Vec<&str> = json
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .collect();
    for name in [
        "final_state",
        "time",
        "steps",
        "wall_seconds",
        "drift",
        "solver",
        "run_directory",
    ] {
        assert!(names.contains(&name), "{name} is missing from {names:?}");
    }
    assert_eq!(json["steps"], 40);
    assert_eq!(json["time"], 40.0 * 0.1);
    assert_eq!(json["final_state"].as_array().map(Vec::len), Some(3));
    // Quadratic Casimirs of a linear tensor are kept to round-off.
    assert!(
        json["drift"]["spin"]
            .as_f64()
            .is_some_and(|drift| drift < 19.0 * 1e-14)
    );
    assert!(
        json["drift"]["energy"]
            .as_f64()
            .is_some_and(|drift| drift > 0.0)
    );
    assert!(
        json["solver"]["evaluations_per_step"]
            .as_f64()
            .is_some_and(|mean| mean >= 1.0)
    );
    assert_eq!(json["solver"]["failures"], 0);
    said.says(&[
        "largest drift",
        "energy",
        "spin",
        "report   runs/scene/report.html",
    ]);
    let directory = json["run_directory"].as_str().expect("a path");
    for file in [
        "scene.toml",
        "manifest.json",
        "samples.csv",
        "windows.csv",
        "checkpoint.bin",
        "report.html",
    ] {
        assert!(here.path(directory).join(file).is_file(), "{file}");
    }
    // Steps 0, 3, …, 39 and the last one.
    assert_eq!(
        here.read("runs/scene/samples.csv").lines().count(),
        1 + 14 + 1
    );
    assert_eq!(here.read("runs/scene/scene.toml"), BODY);
}

#[test]
fn overrides_are_run_and_stored() {
    let here = Place::with(BODY);
    let said = here.leafwise(&[
        "run",
        "scene.toml",
        "--set",
        "run.steps=7",
        "--set",
        "method.dynamics.order=4",
        "--out",
        "elsewhere",
        "--quiet",
    ]);
    assert_eq!(
        (said.code, said.err.as_str(), said.out.as_str()),
        (Some(0), "", "")
    );
    let stored = here.read("elsewhere/scene.toml");
    assert!(
        stored.contains("steps   = 7") && stored.contains("order = 4 }\ntime-step"),
        "{stored}"
    );
    let said = here.leafwise(&["run", "scene.toml", "--set", "method.epsilonn=1"]);
    assert_eq!(said.code, Some(3));
    said.says(&["did you mean `epsilon`?"]);
    let said = here.leafwise(&["run", "scene.toml", "--set", "system.parameters.I22=1"]);
    assert_eq!(said.code, Some(3));
    said.says(&["unknown parameter `I22`", "did you mean `I2`?"]);
    let said = here.leafwise(&["run", "scene.toml", "--set", "run.steps"]);
    assert_eq!(said.code, Some(2));
}

#[test]
fn a_finished_run_is_refused_without_force() {
    let here = Place::with(BODY);
    assert_eq!(here.leafwise(&["run", "scene.toml"]).code, Some(0));
    let before = here.read("runs/scene/manifest.json");
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(2));
    said.says(&["has finished", "--force", "--out"]);
    assert_eq!(here.read("runs/scene/manifest.json"), before);
    assert_eq!(
        here.leafwise(&["run", "scene.toml", "--force"]).code,
        Some(0)
    );
}

#[test]
fn explain_counts_the_operations_of_every_kernel() {
    let here = Place::with(&BODY.replace("order = 2", "order = 8"));
    let said = here.leafwise(&["run", "scene.toml", "--explain"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&[
        "linear (Lie-Poisson)",
        "S_7",
        "Step kernel of dS",
        "Newton iteration",
        "to first step",
    ]);
    let line = said
        .err
        .lines()
        .find(|line| line.contains("Step kernel of dS"))
        .expect("a line");
    let count: usize = line
        .split_whitespace()
        .find_map(|word| word.parse().ok())
        .expect("a number of operations");
    assert!(count <= 200, "{line}");
}

/// A run of a few seconds, started and going.
fn long_run(here: &Place) -> Child {
    let child = here
        .command(&["run", "scene.toml"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let samples = here.path("runs/scene/samples.csv");
    let is_going = || std::fs::metadata(&samples).is_ok_and(|file| file.len() > 20_000);
    wait_for(is_going, "the first sample");
    child
}

/// A scene that takes long enough to be interrupted, and short enough to be finished twice.
fn long_scene() -> String {
    BODY.replace("steps   = 40", "steps   = 200000")
        .replace("every = 3", "every = 7")
}

#[test]
fn a_killed_run_resumes_to_bit_identical_samples() {
    let (whole, pieces) = (Place::with(&long_scene()), Place::with(&long_scene()));
    assert_eq!(whole.leafwise(&["run", "scene.toml"]).code, Some(0));
    let mut child = long_run(&pieces);
    child.kill().expect("killed");
    assert_eq!(child.wait().expect("an end").code(), None);
    let said = pieces.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&["resumed at step"]);
    for file in ["samples.csv", "windows.csv"] {
        let name = format!("runs/scene/{file}");
        assert!(whole.read(&name) == pieces.read(&name), "{file} differs");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_writes_a_checkpoint_exits_130_and_goes_on() {
    let (whole, pieces) = (Place::with(&long_scene()), Place::with(&long_scene()));
    assert_eq!(whole.leafwise(&["run", "scene.toml"]).code, Some(0));
    let mut child = long_run(&pieces);
    let interrupted = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill runs");
    assert!(interrupted.success());
    let status = child.wait().expect("an end");
    let mut text = String::new();
    child
        .stderr
        .take()
        .expect("a pipe")
        .read_to_string(&mut text)
        .expect("UTF-8");
    assert_eq!(status.code(), Some(130), "{text}");
    assert!(
        text.contains("the same command goes on from there"),
        "{text}"
    );
    assert!(
        pieces
            .read("runs/scene/manifest.json")
            .contains("\"outcome\": \"interrupted\"")
    );
    let changed = pieces.leafwise(&["run", "scene.toml", "--set", "method.time-step=0.2"]);
    assert_eq!(changed.code, Some(2));
    changed.says(&["- time-step   = 0.1", "+ time-step   = 0.2"]);
    let said = pieces.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(whole.read("runs/scene/samples.csv") == pieces.read("runs/scene/samples.csv"));
    let manifest = |place: &Place| -> serde_json::Value {
        serde_json::from_str(&place.read("runs/scene/manifest.json")).expect("JSON")
    };
    let (a, b) = (manifest(&whole), manifest(&pieces));
    assert_eq!((&a["drift"], &a["solver"]), (&b["drift"], &b["solver"]));
}

#[test]
fn every_scene_of_the_gallery_passes_its_check_and_runs() {
    let scenes = gallery();
    assert!(scenes.len() >= 12);
    for scene in scenes {
        let here = Place::new();
        let path = scene.to_str().expect("UTF-8");
        let said = here.leafwise(&["check", path]);
        assert_eq!(said.code, Some(0), "{path}\n{}{}", said.out, said.err);
        let arguments = ["run", path, "--set", "run.steps=5", "--json"];
        let said = here.leafwise(&arguments);
        assert_eq!(said.code, Some(0), "{path}\n{}", said.err);
        assert_eq!(said.json()["steps"], 5);
    }
}
