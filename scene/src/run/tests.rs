//! Interrupted and resumed, a run leaves the same samples; refusals leave the directory as it was.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::Path;

use leafwise_core::Registry;

use super::{Progress, Quiet, RunError, RunOptions, RunOutcome, RunReport, Status, run};
use crate::advice::AdviceKind;
use crate::compose::{ComposedRun, compose};
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
    Prepared::new(text).attempt(directory, force, progress)
}

/// A scene, read and composed once.
struct Prepared {
    document: SceneDocument,
    registry: Registry,
    composed: ComposedRun,
}

impl Prepared {
    fn new(text: &str) -> Self {
        let document = SceneDocument::parse("top.toml", text, &NoLibrary).expect("a scene");
        let registry = Registry::with_builtin();
        let composed = compose(&document, &registry).expect("a run");
        Self {
            document,
            registry,
            composed,
        }
    }

    fn attempt(
        &self,
        directory: &Path,
        force: bool,
        progress: &mut dyn Progress,
    ) -> Result<RunReport, RunError> {
        let options = RunOptions {
            directory: directory.to_owned(),
            force,
            allow_non_poisson: false,
            command: "leafwise run top.toml".to_owned(),
            checkpoint_every: RunOptions::CHECKPOINT_EVERY,
        };
        let Self {
            document,
            registry,
            composed,
        } = self;
        run(document, composed, registry, &options, progress)
    }
}

/// The names and contents of a directory.
fn contents(directory: &Path) -> BTreeMap<OsString, Vec<u8>> {
    let entries = fs::read_dir(directory).expect("a readable directory");
    let entries = entries.map(|entry| entry.expect("an entry"));
    entries
        .map(|entry| (entry.file_name(), fs::read(entry.path()).expect("a file")))
        .collect()
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

/// A short run whose samples are all on the grid.
fn short_scene() -> String {
    SCENE
        .replace("steps   = 20000", "steps   = 8")
        .replace("every = 7", "every = 1")
}

#[test]
fn a_flipped_bit_in_any_byte_of_a_checkpoint_is_refused_and_force_starts_over() {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    let scene = Prepared::new(&short_scene());
    let whole = scene.attempt(&path, false, &mut Quiet).expect("a run");
    let checkpoint = path.join("checkpoint.bin");
    let good = fs::read(&checkpoint).expect("a checkpoint");
    for at in 0..good.len() {
        let mut flipped = good.clone();
        flipped[at] ^= 1 << (at % 8);
        fs::write(&checkpoint, &flipped).expect("writable");
        let before = contents(&path);
        let error = scene.attempt(&path, false, &mut Quiet).expect_err("damage");
        assert!(
            matches!(error, RunError::Damaged { .. }),
            "byte {at}: {error}"
        );
        let text = error.to_string();
        assert!(
            text.contains("checkpoint.bin") && text.contains("--force") && text.contains("--out"),
            "{text}"
        );
        assert!(
            contents(&path) == before,
            "byte {at}: something was written"
        );
    }
    let again = scene.attempt(&path, true, &mut Quiet).expect("a run anew");
    assert_eq!(again.final_state, whole.final_state);
}

#[test]
fn a_changed_digit_of_the_samples_is_refused_and_nothing_is_written() {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    let scene = Prepared::new(&short_scene());
    scene.attempt(&path, false, &mut Quiet).expect("a run");
    let samples = path.join("samples.csv");
    let good = fs::read(&samples).expect("samples");
    let digits: Vec<usize> = (0..good.len())
        .filter(|at| good[*at].is_ascii_digit())
        .collect();
    assert!(digits.len() > 500, "{} digits", digits.len());
    for at in digits {
        let mut changed = good.clone();
        changed[at] = if changed[at] == b'9' {
            b'8'
        } else {
            changed[at] + 1
        };
        fs::write(&samples, &changed).expect("writable");
        let before = contents(&path);
        let error = scene.attempt(&path, false, &mut Quiet).expect_err("damage");
        let text = error.to_string();
        assert!(
            text.contains("samples.csv")
                && text.contains("changed since")
                && text.contains("--force"),
            "byte {at}: {text}"
        );
        assert!(
            contents(&path) == before,
            "byte {at}: something was written"
        );
    }
    fs::write(&samples, &good).expect("writable");
    assert!(
        scene
            .attempt(&path, false, &mut Quiet)
            .expect("as it was")
            .is_repeated
    );
}

#[test]
fn a_finished_run_of_the_same_scene_is_told_again_and_nothing_is_written() {
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

/// The cells of a line of CSV.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut is_quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            _ => cells.last_mut().expect("a cell").push(letter),
        }
    }
    cells
}

#[test]
fn names_of_several_lines_are_one_heading_and_the_run_ends() {
    let root = tempfile::tempdir().expect("a directory");
    let (whole, path) = (root.path().join("whole"), root.path().join("run"));
    let scene = SCENE
        .replace("spin =", "\"sp\\nin\" =")
        .replace("\"x1*x2\"", "\"x1\\n*x2\", \"sp\\nin\"");
    attempt(&scene, &whole, false, &mut Quiet).expect("a run");
    while attempt(&scene, &path, false, &mut StopAfter(5))
        .expect("a session")
        .outcome
        == RunOutcome::Interrupted
    {}
    for file in ["samples.csv", "windows.csv"] {
        let read = |directory: &Path| fs::read_to_string(directory.join(file)).expect(file);
        assert!(read(&whole) == read(&path), "{file} differs");
    }
    let samples = fs::read_to_string(path.join("samples.csv")).expect("samples");
    let header = "t,x1,x2,x3,energy,\"x1\n*x2\",\"sp\nin\"\n";
    assert!(samples.starts_with(header), "{}", &samples[..100]);
    for row in samples[header.len()..].lines() {
        assert_eq!(row.split(',').count(), 7, "{row}");
    }
    let windows = fs::read_to_string(path.join("windows.csv")).expect("windows");
    assert!(
        windows.starts_with("t_end,energy,\"sp\nin\"\n"),
        "{}",
        &windows[..60]
    );
}

#[test]
fn every_column_has_a_heading_of_its_own_and_none_is_a_formula_of_a_spreadsheet() {
    let root = tempfile::tempdir().expect("a directory");
    let scene = short_scene()
        .replace("{ spin =", "{ \"=x1\" = \"2*(x1^2 + x2^2 + x3^2)\", x2 =")
        .replace(
            "\"energy\", \"x1*x2\"",
            "\"energy\", \"x1\", \"x2\", \"=x1\", \"-x3\"",
        );
    attempt(&scene, root.path(), false, &mut Quiet).expect("a run");
    let samples = fs::read_to_string(root.path().join("samples.csv")).expect("samples");
    let header = samples.lines().next().expect("a line");
    assert_eq!(
        header,
        "t,x1,x2,x3,energy,x1 (observable),x2 (Casimir),\"=x1\",\"-x3\""
    );
    assert_eq!(cells(header).len(), 9);
    let row: Vec<f64> = cells(samples.lines().last().expect("a row"))
        .iter()
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    assert_eq!((row[5], row[8]), (row[1], -row[3]));
    assert_eq!(row[7], 2.0 * row[6]);
}

#[test]
fn an_observable_without_a_value_is_warned_of() {
    let root = tempfile::tempdir().expect("a directory");
    // x3 is −0.5 first.
    let scene = SCENE.replace("\"x1*x2\"", "\"ln(x3)\", \"x1*x2\"");
    let mut sessions = 0;
    let report = loop {
        let report = attempt(&scene, root.path(), false, &mut StopAfter(5)).expect("a session");
        sessions += 1;
        if report.outcome == RunOutcome::Done {
            break report;
        }
    };
    assert!(sessions > 1);
    let samples = fs::read_to_string(root.path().join("samples.csv")).expect("samples");
    let rows = samples.lines().skip(1);
    let undefined = rows
        .filter(|row| row.split(',').nth(5) == Some("NaN"))
        .count();
    assert!(undefined > 0);
    let of_kind = |advice: &&crate::advice::Advice| advice.kind == AdviceKind::UndefinedObservable;
    let advice: Vec<_> = report.advice.iter().filter(of_kind).collect();
    assert_eq!(advice.len(), 1, "{advice:?}");
    let said = format!(
        "`ln(x3)` has no finite value at {undefined} of {} samples",
        report.samples
    );
    assert!(
        advice[0].message.starts_with(&said),
        "{}\n{said}",
        advice[0].message
    );
}
