//! Interrupted and resumed, a run leaves the same samples; refusals leave the directory as it was.

use std::fs;
use std::path::Path;

use leafwise_core::Registry;

use super::{Progress, Quiet, RunError, RunOptions, RunOutcome, RunReport, Status, run};
use crate::compose::compose;
use crate::document::{NoLibrary, SceneDocument};

const SCENE: &str = r#"
[system]
variables   = ["x1", "x2", "x3"]
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/2 + x2^2/1.5 + x3^2/2.5"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }
[method]
realization = { name = "karasev-truncated", order = 4 }
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.1
[run]
initial = [1, 2, -0.5]
steps   = 20000
record  = { every = 7, observables = ["energy", "x1*x2"] }
"#;

/// Stops after a number of looks.
struct StopAfter(u32);

impl Progress for StopAfter {
    fn show(&mut self, _status: &Status) {
        self.0 = self.0.saturating_sub(1);
    }

    fn is_interrupted(&self) -> bool {
        self.0 == 0
    }
}

fn attempt(
    text: &str,
    directory: &Path,
    force: bool,
    progress: &mut dyn Progress,
) -> Result<RunReport, RunError> {
    let document = SceneDocument::parse("top.toml", text, &NoLibrary).expect("a scene");
    let registry = Registry::with_builtin();
    let composed = compose(&document, &registry).expect("a run");
    let options = RunOptions {
        directory: directory.to_owned(),
        force,
        allow_non_poisson: false,
        command: "leafwise run top.toml".to_owned(),
        checkpoint_every: RunOptions::CHECKPOINT_EVERY,
    };
    run(&document, &composed, &registry, &options, progress)
}

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
    let error = attempt(SCENE, &path, false, &mut Quiet).expect_err("a finished run");
    assert!(matches!(error, RunError::Ended { .. }), "{error}");
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
fn a_failure_leaves_everything_recorded_before_it() {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    let far = SCENE.replace("time-step   = 0.1", "time-step   = 4.0");
    let report = attempt(&far, &path, false, &mut Quiet).expect("an outcome");
    let RunOutcome::Failed(failure) = &report.outcome else {
        panic!("{:?}", report.outcome)
    };
    assert_eq!(failure.step, report.steps + 1);
    let samples = fs::read_to_string(path.join("samples.csv")).expect("samples");
    let last = samples.lines().last().expect("a row");
    let state: Vec<f64> = last
        .split(',')
        .skip(1)
        .take(3)
        .map(|x| x.parse().expect("a number"))
        .collect();
    assert_eq!(state, failure.state);
    let manifest = fs::read_to_string(path.join("manifest.json")).expect("a manifest");
    assert!(manifest.contains("\"outcome\": \"failed\""));
    assert!(
        fs::read_to_string(path.join("report.html"))
            .expect("a report")
            .contains("Failed at")
    );
}
