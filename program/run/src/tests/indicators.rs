//! Indicators of chaos in directories.

use std::fs;

use super::{SCENE, StopAfter, attempt};
use crate::{MotionKind, Quiet, RunOutcome};

/// The vectors are in the checkpoint: pieces have the bits of the whole, also where a run becomes longer.
#[test]
fn an_interrupted_run_has_the_indicators_of_a_whole_one() {
    let scene = SCENE.replace(
        "observables = [\"energy\", \"x1*x2\"]",
        "observables = [\"megno\", \"energy\", \"lyapunov 1\", \"x1*x2\", \"sali\"]",
    );
    let root = tempfile::tempdir().expect("a directory");
    let (whole, pieces) = (root.path().join("whole"), root.path().join("pieces"));
    let reference = attempt(&scene, &whole, false, &mut Quiet).expect("a run");
    let verdict = reference.chaos.expect("MEGNO is recorded");
    assert_eq!(verdict.motion, MotionKind::Regular);
    let shorter = scene.replace("steps   = 20000", "steps   = 9999");
    let report = attempt(&shorter, &pieces, false, &mut StopAfter(2)).expect("a session");
    assert_eq!(report.outcome, RunOutcome::Interrupted);
    attempt(&shorter, &pieces, false, &mut Quiet).expect("the shorter run");
    let resumed = attempt(&scene, &pieces, false, &mut Quiet).expect("the longer run");
    assert_eq!(resumed.outcome, RunOutcome::Done);
    assert_eq!(resumed.chaos, reference.chaos);
    let read = |directory: &std::path::Path| fs::read(directory.join("samples.csv"));
    assert!(read(&whole).expect("rows") == read(&pieces).expect("rows"));
    let text = fs::read_to_string(whole.join("samples.csv")).expect("rows");
    let heading = text.lines().next().expect("a line");
    assert_eq!(heading, "t,x1,x2,x3,megno,energy,lyapunov 1,x1*x2,sali");
}
