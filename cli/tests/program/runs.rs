//! Runs from the command line: objects, directories, overrides.

use crate::support::{BODY, Place, gallery};

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
