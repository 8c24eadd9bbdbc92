//! What a run failed at, and files that were changed since, are reported.

use std::fs;

use super::{Prepared, SCENE, attempt, check_end_files, contents, short_scene};
use crate::{Quiet, RunError, RunOutcome};

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

#[test]
fn a_changed_digit_of_the_samples_is_refused_and_nothing_is_written() {
    // The last sample of the second is off the grid, and not counted by the checkpoint.
    for text in [
        short_scene(),
        short_scene().replace("every = 1", "every = 3"),
    ] {
        let root = tempfile::tempdir().expect("a directory");
        let path = root.path().join("run");
        let scene = Prepared::new(&text);
        let whole = scene.attempt(&path, false, &mut Quiet).expect("a run");
        let samples = path.join("samples.csv");
        let good = fs::read(&samples).expect("samples");
        let digits: Vec<usize> = (0..good.len())
            .filter(|at| good[*at].is_ascii_digit())
            .collect();
        assert!(digits.len() as u64 > 60 * whole.samples, "{}", digits.len());
        for at in digits {
            let mut changed = good.clone();
            changed[at] = match changed[at] {
                b'9' => b'8',
                digit => digit + 1,
            };
            fs::write(&samples, &changed).expect("writable");
            let before = contents(&path);
            let error = scene.attempt(&path, false, &mut Quiet).expect_err("damage");
            let said = error.to_string();
            let is_told = ["samples.csv", "changed since", "--force"];
            let is_told = is_told.iter().all(|words| said.contains(words));
            assert!(is_told, "byte {at}: {said}");
            assert!(
                contents(&path) == before,
                "byte {at}: something was written"
            );
        }
        fs::write(&samples, &good).expect("writable");
        let again = scene.attempt(&path, false, &mut Quiet).expect("as it was");
        assert!(again.is_repeated);
    }
}

#[test]
fn tables_and_pages_of_a_finished_run_are_made_anew_where_they_are_lost_and_refused_where_they_changed()
 {
    let root = tempfile::tempdir().expect("a directory");
    let path = root.path().join("run");
    // The second keeps its last state in a file of its own.
    for (text, files) in [
        (short_scene(), &["windows.csv", "report.html"][..]),
        (
            short_scene().replace("every = 1,", "every = 1, states = [\"x1\"],"),
            &["windows.csv", "final_state.bin", "report.html"],
        ),
    ] {
        let scene = Prepared::new(&text);
        scene.attempt(&path, true, &mut Quiet).expect("a run");
        check_end_files(&path, files, || {
            let report = scene.attempt(&path, false, &mut Quiet)?;
            assert!(report.is_repeated);
            Ok(())
        });
    }
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
