//! Interrupted, killed, extended or told again, a run leaves the same files.

use std::fs;
use std::path::Path;

use super::{Prepared, SCENE, StopAfter, attempt, contents, short_scene};
use crate::checkpoint::Checkpoint;
use crate::{Quiet, RunError, RunOutcome};

#[test]
fn an_interrupted_run_resumes_to_the_same_bits() {
    let root = tempfile::tempdir().expect("a directory");
    let (whole, pieces) = (root.path().join("whole"), root.path().join("pieces"));
    let reference = attempt(SCENE, &whole, false, &mut Quiet).expect("a run");
    assert_eq!(reference.outcome, RunOutcome::Done);
    let mut sessions = 0;
    let resumed = loop {
        let report = attempt(SCENE, &pieces, false, &mut StopAfter(3)).expect("a session");
        sessions += 1;
        if report.outcome == RunOutcome::Done {
            break report;
        }
        assert_eq!(report.outcome, RunOutcome::Interrupted);
        // What a kill after the checkpoint leaves behind: rows that it does not count.
        let samples = pieces.join("samples.csv");
        let mut text = fs::read_to_string(&samples).expect("samples");
        text.push_str("12.5,1.0");
        fs::write(&samples, text).expect("writable");
    };
    assert!(sessions >= 3, "{sessions} sessions");
    for file in ["samples.csv", "windows.csv", "scene.toml"] {
        let read = |directory: &Path| fs::read(directory.join(file)).expect(file);
        assert!(read(&whole) == read(&pieces), "{file} differs");
    }
    assert_eq!(resumed.final_state, reference.final_state);
    assert_eq!(resumed.statistics, reference.statistics);
    assert_eq!(resumed.invariants, reference.invariants);
    // What the method is judged at, and what is said of it, are those of the whole run too.
    let watched = |directory: &Path| Checkpoint::of_any_scene(directory).watch;
    assert_eq!(watched(&pieces), watched(&whole));
    assert_eq!(resumed.advice, reference.advice);
}

#[test]
fn a_kill_after_the_last_step_adds_nothing() {
    // The last sample is one that only the end of the run asks for: 20000 is no multiple of 7.
    let failing = SCENE.replace("time-step   = 0.1", "time-step   = 4.0");
    for scene in [SCENE, &failing] {
        let root = tempfile::tempdir().expect("a directory");
        let path = root.path().join("run");
        let whole = attempt(scene, &path, false, &mut Quiet).expect("a run");
        let before = fs::read(path.join("samples.csv")).expect("samples");
        // What a kill before the manifest's last version leaves behind.
        let manifest = path.join("manifest.json");
        let text = fs::read_to_string(&manifest).expect("a manifest");
        let word = if scene == SCENE { "done" } else { "failed" };
        let from = format!("\"outcome\": \"{word}\"");
        assert!(text.contains(&from), "{text}");
        fs::write(&manifest, text.replace(&from, "\"outcome\": \"running\"")).expect("writable");
        let again = attempt(scene, &path, false, &mut Quiet).expect("the end of the run");
        assert_eq!(again.outcome, whole.outcome);
        assert_eq!(again.statistics, whole.statistics);
        assert_eq!(again.samples, whole.samples);
        let after = fs::read(path.join("samples.csv")).expect("samples");
        assert!(after == before, "the samples of a run that was {word}");
    }
}

#[test]
fn samples_behind_the_checkpoint_stay_on_disk_through_a_second_kill() {
    let root = tempfile::tempdir().expect("a directory");
    let (whole, pieces) = (root.path().join("whole"), root.path().join("pieces"));
    attempt(SCENE, &whole, false, &mut Quiet).expect("a run");
    attempt(SCENE, &pieces, false, &mut StopAfter(1)).expect("a session");
    // A kill long after the checkpoint: all rows are on disk, the last one in part.
    let all = fs::read(whole.join("samples.csv")).expect("samples");
    fs::write(pieces.join("samples.csv"), &all[..all.len() - 5]).expect("writable");
    let report = attempt(SCENE, &pieces, false, &mut StopAfter(1)).expect("a session");
    assert_eq!(report.outcome, RunOutcome::Interrupted);
    let kept = fs::read(pieces.join("samples.csv")).expect("samples");
    let rows = all[..all.len() - 5].iter().rposition(|byte| *byte == b'\n');
    assert!(kept == all[..=rows.expect("rows")], "whole rows stay");
    attempt(SCENE, &pieces, false, &mut Quiet).expect("the rest");
    assert!(fs::read(pieces.join("samples.csv")).expect("samples") == all);
}

#[test]
fn other_comments_are_the_same_scene() {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    attempt(SCENE, &path, false, &mut StopAfter(1)).expect("a session");
    let commented = format!(
        "# later thoughts\n{}",
        SCENE.replace(" = 20000", " = 20000 # long")
    );
    let report = attempt(&commented, &path, false, &mut Quiet).expect("the rest");
    assert_eq!(report.outcome, RunOutcome::Done);
    assert!(report.resumed_at.is_some());
    assert_eq!(
        fs::read_to_string(path.join("scene.toml")).expect("a scene"),
        commented
    );
}

#[test]
fn an_interrupted_lattice_resumes_to_the_same_bits() {
    let lattice = r#"
[system]
families    = { x = 100 }
bracket     = { "x[i],x[i+1]" = "x[i]*x[i+1]" }
boundary    = "periodic"
hamiltonian = "sum(i, x[i] + x[i]^2/8)"
casimirs    = { logarithm = "sum(i, ln(x[i]))" }
[method]
realization = { name = "karasev-truncated", order = 2 }
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.05
[run]
initial = { "x[i]" = "1 + 0.1*sin(2*pi*i/N)" }
steps   = 1000
record  = { every = 3, observables = ["energy", "sum(i, x[i]^2)"] }
"#;
    let root = tempfile::tempdir().expect("a directory");
    let (whole, pieces) = (root.path().join("whole"), root.path().join("pieces"));
    let reference = attempt(lattice, &whole, false, &mut Quiet).expect("a run");
    assert_eq!(reference.outcome, RunOutcome::Done);
    while attempt(lattice, &pieces, false, &mut StopAfter(5))
        .expect("a session")
        .outcome
        == RunOutcome::Interrupted
    {}
    for file in ["samples.csv", "windows.csv", "final_state.bin"] {
        let read = |directory: &Path| fs::read(directory.join(file)).expect(file);
        assert!(read(&whole) == read(&pieces), "{file} differs");
    }
    let report = fs::read_to_string(pieces.join("report.html")).expect("a report");
    assert!(report.contains("x over space and time"));
}

/// What is on disk between the first sample and the first checkpoint.
#[test]
fn a_run_killed_before_its_first_checkpoint_begins_anew() {
    let root = tempfile::tempdir().expect("a directory");
    let [whole, killed] = ["whole", "killed"].map(|name| root.path().join(name));
    attempt(SCENE, &whole, false, &mut Quiet).expect("a run");
    attempt(SCENE, &killed, false, &mut StopAfter(1)).expect("a session");
    let samples = killed.join("samples.csv");
    let first: String = fs::read_to_string(&samples)
        .expect("samples")
        .split_inclusive('\n')
        .take(2)
        .collect();
    fs::write(&samples, &first).expect("writable");
    fs::remove_file(killed.join("checkpoint.bin")).expect("a checkpoint");
    let report = attempt(SCENE, &killed, false, &mut Quiet).expect("a run");
    assert_eq!(
        (report.outcome, report.resumed_at),
        (RunOutcome::Done, None)
    );
    let both = [&whole, &killed].map(|path| fs::read(path.join("samples.csv")).expect("samples"));
    assert!(both[0] == both[1] && both[0].starts_with(first.as_bytes()));
}

#[test]
fn a_finished_run_of_the_same_scene_is_reported_again_and_nothing_is_written() {
    // The last sample of the second is off the grid.
    for scene in [
        short_scene(),
        short_scene().replace("every = 1", "every = 3"),
    ] {
        let root = tempfile::tempdir().expect("a directory");
        let path = root.path().join("run");
        let whole = attempt(&scene, &path, false, &mut Quiet).expect("a run");
        assert!(!whole.is_repeated);
        let before = contents(&path);
        let commented = format!("# the same\n{scene}");
        let again = attempt(&commented, &path, false, &mut Quiet).expect("the run");
        assert!(again.is_repeated);
        assert_eq!(again.outcome, RunOutcome::Done);
        assert_eq!(again.final_state, whole.final_state);
        assert_eq!(again.statistics, whole.statistics);
        assert_eq!(again.invariants, whole.invariants);
        assert_eq!(again.advice, whole.advice);
        assert_eq!((again.samples, again.steps), (whole.samples, whole.steps));
        assert_eq!(again.resumed_at, None);
        assert!(contents(&path) == before, "something was written");
    }
}

#[test]
fn more_steps_continue_a_run_to_the_same_bits() {
    let root = tempfile::tempdir().expect("a directory");
    let with = |steps: u64| SCENE.replace("20000", &steps.to_string());
    let whole = root.path().join("whole");
    let reference = attempt(&with(9000), &whole, false, &mut Quiet).expect("a run");
    // Finished off the grid of samples and on it, interrupted, and both.
    let finished = |path: &Path, steps: u64| {
        let report = attempt(&with(steps), path, false, &mut Quiet).expect("a run");
        assert_eq!(report.outcome, RunOutcome::Done);
    };
    let interrupted = |path: &Path| {
        let report = attempt(&with(20_000), path, false, &mut StopAfter(2)).expect("a session");
        assert_eq!(report.outcome, RunOutcome::Interrupted);
    };
    type Before<'a> = &'a dyn Fn(&Path);
    let histories: [(&str, Before<'_>); 4] = [
        ("off", &|path| finished(path, 3000)),
        ("on", &|path| finished(path, 2800)),
        ("interrupted", &|path| interrupted(path)),
        ("twice", &|path| {
            finished(path, 10);
            finished(path, 11);
        }),
    ];
    for (name, before) in histories {
        let path = root.path().join(name);
        before(&path);
        let report = attempt(&with(9000), &path, false, &mut Quiet).expect("the rest");
        assert!(report.resumed_at.is_some_and(|step| step > 0), "{name}");
        assert_eq!(report.final_state, reference.final_state, "{name}");
        assert_eq!(report.statistics, reference.statistics, "{name}");
        assert_eq!(report.invariants, reference.invariants, "{name}");
        assert_eq!(report.samples, reference.samples, "{name}");
        for file in ["samples.csv", "windows.csv", "scene.toml"] {
            let read = |directory: &Path| fs::read(directory.join(file)).expect(file);
            assert!(read(&whole) == read(&path), "{name}: {file} differs");
        }
        let error = attempt(&with(8999), &path, false, &mut Quiet).expect_err("fewer steps");
        assert!(
            matches!(
                error,
                RunError::Shortened {
                    made: 9000,
                    asked: 8999,
                    ..
                }
            ),
            "{error}"
        );
    }
}

#[test]
fn a_kill_while_a_run_becomes_longer_loses_nothing() {
    let root = tempfile::tempdir().expect("a directory");
    let (whole, path) = (root.path().join("whole"), root.path().join("run"));
    let (short, long) = (SCENE.replace("20000", "30"), SCENE.replace("20000", "60"));
    attempt(&long, &whole, false, &mut Quiet).expect("a run");
    // Between any two of: the manifest says `running`, the row off the grid goes, the scene is the longer.
    for stage in 1..=3 {
        attempt(&short, &path, true, &mut Quiet).expect("a run");
        let samples = fs::read_to_string(path.join("samples.csv")).expect("samples");
        let manifest = path.join("manifest.json");
        let text = fs::read_to_string(&manifest).expect("a manifest");
        fs::write(&manifest, text.replace("\"done\"", "\"running\"")).expect("writable");
        if stage >= 2 {
            let end = samples.trim_end().rfind('\n').expect("rows") + 1;
            fs::write(path.join("samples.csv"), &samples[..end]).expect("writable");
        }
        if stage >= 3 {
            fs::write(path.join("scene.toml"), &long).expect("writable");
        } else {
            // The shorter run is as it was.
            let report = attempt(&short, &path, false, &mut Quiet).expect("the shorter run");
            assert_eq!((report.outcome, report.steps), (RunOutcome::Done, 30));
            let now = fs::read_to_string(path.join("samples.csv")).expect("samples");
            assert_eq!(now, samples, "stage {stage}");
        }
        attempt(&long, &path, false, &mut Quiet).expect("the longer run");
        let read = |directory: &Path| fs::read(directory.join("samples.csv")).expect("samples");
        assert!(read(&whole) == read(&path), "stage {stage}");
    }
}

#[test]
fn a_run_killed_with_nothing_but_its_manifest_begins_anew() {
    let root = tempfile::tempdir().expect("a directory");
    let scene = Prepared::new(&short_scene());
    let whole = scene
        .attempt(root.path(), false, &mut Quiet)
        .expect("a run");
    let manifest = root.path().join("manifest.json");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    for name in [
        "scene.toml",
        "samples.csv",
        "checkpoint.bin",
        "windows.csv",
        "report.html",
    ] {
        fs::remove_file(root.path().join(name)).expect(name);
    }
    fs::write(&manifest, text.replace("\"done\"", "\"running\"")).expect("writable");
    let report = scene
        .attempt(root.path(), false, &mut Quiet)
        .expect("a run");
    assert_eq!(report.final_state, whole.final_state);
    assert_eq!(report.samples, whole.samples);
}
