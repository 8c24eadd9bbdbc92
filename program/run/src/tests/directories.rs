//! Whose a directory is, and what happens to the files in it.

use std::fs;

use super::{Prepared, SCENE, StopAfter, attempt, contents, short_scene};
use crate::{Quiet, RunError, RunOutcome};

#[test]
fn a_finished_run_and_a_changed_scene_are_refused_and_force_replaces() {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    attempt(SCENE, &path, false, &mut StopAfter(1)).expect("a session");
    let changed = SCENE.replace("time-step   = 0.1", "time-step   = 0.2");
    let before = fs::read(path.join("samples.csv")).expect("samples");
    let error = attempt(&changed, &path, false, &mut Quiet).expect_err("a changed scene");
    let text = error.to_string();
    assert!(text.contains("  method.time-step: 0.1 → 0.2\n"), "{text}");
    assert_eq!(fs::read(path.join("samples.csv")).expect("samples"), before);
    attempt(SCENE, &path, false, &mut Quiet).expect("the rest");
    let error = attempt(&changed, &path, false, &mut Quiet).expect_err("a finished run");
    assert!(matches!(error, RunError::Ended { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("  method.time-step: 0.1 → 0.2\n"), "{text}");
    let report = attempt(&changed, &path, true, &mut Quiet).expect("replaced");
    assert_eq!(
        (report.outcome, report.resumed_at),
        (RunOutcome::Done, None)
    );
}

#[test]
fn an_unfinished_run_that_lost_a_file_says_which_and_starts_over_with_force() {
    for file in ["checkpoint.bin", "samples.csv", "scene.toml"] {
        let root = tempfile::tempdir().expect("a directory");
        let path = root.path().join("run");
        attempt(SCENE, &path, false, &mut StopAfter(1)).expect("a session");
        fs::remove_file(path.join(file)).expect(file);
        let error = attempt(SCENE, &path, false, &mut Quiet).expect_err(file);
        let text = error.to_string();
        assert!(
            text.contains(file) && text.contains("missing") && text.contains("--force"),
            "{text}"
        );
        let report = attempt(SCENE, &path, true, &mut Quiet).expect("a run");
        assert_eq!(report.outcome, RunOutcome::Done);
    }
}

#[test]
fn a_directory_with_other_files_is_left_alone() {
    let root = tempfile::tempdir().expect("a directory");
    fs::write(root.path().join("thesis.tex"), "x").expect("writable");
    for force in [false, true] {
        let error = attempt(SCENE, root.path(), force, &mut Quiet).expect_err("foreign");
        assert!(matches!(error, RunError::Foreign { .. }), "{error}");
    }
    assert_eq!(fs::read_dir(root.path()).expect("readable").count(), 1);
}

#[test]
fn a_violated_identity_is_refused_before_anything_is_written() {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    let broken = SCENE
        .replace("\"-x3\"", "\"-x3 + x1*x2\"")
        .replace("casimirs", "#");
    let error = attempt(&broken, &path, false, &mut Quiet).expect_err("not Poisson");
    assert!(matches!(error, RunError::Refused(_)), "{error}");
    let false_casimir = SCENE.replace("\"x1^2 + x2^2 + x3^2\"", "\"x1^2 + x2^2\"");
    let error = attempt(&false_casimir, &path, false, &mut Quiet).expect_err("not a Casimir");
    let RunError::Refused(diagnostic) = error else {
        panic!("{error}")
    };
    assert_eq!(diagnostic.line_column(), (6, 25));
    assert!(!path.exists());
}

#[test]
fn only_the_manifest_of_a_run_makes_a_directory_ours() {
    let scene = Prepared::new(&short_scene());
    let own = [
        "scene.toml",
        "samples.csv",
        "report.html",
        "final_states.csv",
    ];
    for (file, text) in [
        (".lock", ""),
        ("manifest.json", ""),
        ("manifest.json", "{}"),
        ("manifest.json", "{\"name\": \"a web page\"}"),
        (
            "manifest.json",
            "{\"program\": \"other\", \"version\": \"1\", \"outcome\": \"running\", \"started\": \"\"}",
        ),
    ] {
        let root = tempfile::tempdir().expect("a directory");
        fs::write(root.path().join(file), text).expect("writable");
        for name in own {
            fs::write(root.path().join(name), "mine").expect("writable");
        }
        let before = contents(root.path());
        for force in [false, true] {
            let error = scene
                .attempt(root.path(), force, &mut Quiet)
                .expect_err("foreign");
            assert!(
                matches!(error, RunError::Foreign { .. }),
                "{file} {text}: {error}"
            );
            assert!(contents(root.path()) == before, "{file} {text}");
        }
    }
    // What a kill before the manifest leaves is nobody's.
    let root = tempfile::tempdir().expect("a directory");
    fs::write(root.path().join(".lock"), "").expect("writable");
    scene
        .attempt(root.path(), false, &mut Quiet)
        .expect("a run");
    // Cut off, the manifest of a finished run is no leave to replace it.
    let manifest = fs::read(root.path().join("manifest.json")).expect("a manifest");
    fs::write(root.path().join("manifest.json"), &manifest[..50]).expect("writable");
    let before = contents(root.path());
    let error = scene
        .attempt(root.path(), true, &mut Quiet)
        .expect_err("foreign");
    assert!(matches!(error, RunError::Foreign { .. }), "{error}");
    assert!(contents(root.path()) == before);
}

#[test]
fn what_force_removes_are_the_files_of_a_run() {
    let root = tempfile::tempdir().expect("a directory");
    let scene = Prepared::new(&short_scene());
    scene
        .attempt(root.path(), false, &mut Quiet)
        .expect("a run");
    // Made by their owner from the samples; an ensemble has files of these names.
    for name in ["statistics.csv", "final_states.csv", "notes.txt"] {
        fs::write(root.path().join(name), "mine").expect("writable");
    }
    scene
        .attempt(root.path(), true, &mut Quiet)
        .expect("a run anew");
    for name in ["statistics.csv", "final_states.csv", "notes.txt"] {
        assert_eq!(fs::read(root.path().join(name)).expect(name), b"mine");
    }
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_links_in_the_directory() {
    use std::os::unix::fs::symlink;
    let root = tempfile::tempdir().expect("a directory");
    let (path, victim) = (root.path().join("run"), root.path().join("victim"));
    let scene = Prepared::new(&short_scene());
    fs::write(&victim, "mine").expect("writable");
    scene.attempt(&path, false, &mut Quiet).expect("a run");
    let planted = [
        "samples",
        "manifest",
        "scene",
        "checkpoint",
        "windows",
        "report",
    ];
    let links = planted.map(|name| path.join(format!("{name}.new")));
    let others = ["report.html", "windows.csv", "samples.csv"].map(|name| path.join(name));
    for link in links.iter().chain(&others) {
        let _ = fs::remove_file(link);
        symlink(&victim, link).expect("a link");
    }
    scene.attempt(&path, true, &mut Quiet).expect("a run anew");
    assert_eq!(fs::read(&victim).expect("a file"), b"mine");
}
