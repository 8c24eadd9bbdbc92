//! However an ensemble is cut into shards, in whatever order these run, and wherever they are interrupted: the bytes are those of
//! one process.

use std::fs;
use std::path::PathBuf;

use super::*;
use crate::shards::{MergeError, Shards, Whole};
use crate::{Quiet, RunOutcome, Status};

const FILES: [&str; 4] = [
    "statistics.csv",
    "windows.csv",
    "final_states.csv",
    "scene.toml",
];

const MANY: &str = "members = 333\nseed = 5\ninitial = { ball = 0.2 }\n\
    parameters = { I2 = { normal = [0.75, 0.01] } }\n\
    record = { every = 10, observables = [\"energy\", \"x1*x2\"], quantiles = [0.25, 0.5] }\n\
    final-states = \"csv\"";

/// Interrupts once some steps are made.
struct Hasty(u64);

impl Progress for Hasty {
    fn show(&mut self, status: &Status) {
        self.0 = self.0.saturating_sub(status.steps);
    }
    fn is_interrupted(&self) -> bool {
        self.0 == 0
    }
}

fn shard(
    document: &SceneDocument,
    shard: &Shard,
    directory: &Path,
    force: Workforce,
    progress: &mut dyn Progress,
) -> Result<EnsembleReport, RunError> {
    make(document, Some(shard), &options(directory), force, progress)
}

fn merged(
    document: &SceneDocument,
    shards: &[PathBuf],
    into: &Path,
) -> Result<EnsembleReport, MergeError> {
    let (shards, ensemble, options) = (Shards::find(shards)?, composed(document), options(into));
    let (portion, force) = (Portion::merged(&shards)?, workforce(1, 64));
    let job = EnsembleJob::new(document, &ensemble, portion, &options, force)?;
    Ok(perform(&job, &mut Quiet)?)
}

fn is_same(whole: &Path, merged: &Path, files: &[&str]) {
    for file in files {
        let [a, b] = [whole, merged].map(|path| fs::read(path.join(file)).expect(file));
        assert!(a == b, "{file} differs");
    }
}

#[test]
fn shards_are_merged_to_the_bytes_of_one_process() {
    for method in METHODS {
        let document = scene(method, MANY);
        let root = tempfile::tempdir().expect("a directory");
        let whole = root.path().join("whole");
        let report = attempt(&document, &whole, workforce(2, 16), &mut Quiet);
        assert_eq!(report.expect("an ensemble").outcome, RunOutcome::Done);
        let folder = root.path().join("shards");
        // Six leaves in four shards, in another order, with other lanes; one of them in pieces.
        for (number, lanes) in [(3, 1), (1, 64), (4, 7), (2, 128)] {
            let one = Shard::of(Whole::Members, number, 4, 333).expect("a shard");
            let directory = folder.join(one.name());
            if number == 1 {
                let begun = shard(&document, &one, &directory, workforce(1, 3), &mut Hasty(1));
                assert_eq!(begun.expect("begun").outcome, RunOutcome::Interrupted);
            }
            let done = shard(&document, &one, &directory, workforce(2, lanes), &mut Quiet);
            assert_eq!(done.expect("a shard").outcome, RunOutcome::Done);
            let again = shard(&document, &one, &directory, workforce(1, 64), &mut Quiet);
            assert!(again.expect("a shard").is_repeated);
        }
        let into = root.path().join("merged");
        let report = merged(&document, &[folder], &into).expect("merged");
        assert_eq!(report.reductions.members, 333);
        is_same(&whole, &into, &FILES);
    }
}

/// The matrix holds what the decimals do.
#[test]
fn a_matrix_of_last_states_is_merged_and_is_that_of_the_decimals() {
    let root = tempfile::tempdir().expect("a directory");
    let document = scene(METHODS[0], &MANY.replace("\"csv\"", "\"npy\""));
    let whole = root.path().join("whole");
    attempt(&document, &whole, workforce(2, 16), &mut Quiet).expect("an ensemble");
    let folder = root.path().join("shards");
    for number in [2, 1] {
        let one = Shard::of(Whole::Members, number, 2, 333).expect("a shard");
        let directory = folder.join(one.name());
        shard(&document, &one, &directory, workforce(1, 64), &mut Quiet).expect("a shard");
    }
    let into = root.path().join("merged");
    merged(&document, &[folder], &into).expect("merged");
    is_same(&whole, &into, &["statistics.csv", "final_states.npy"]);
    let decimals = root.path().join("decimals");
    let document = scene(METHODS[0], MANY);
    attempt(&document, &decimals, workforce(2, 16), &mut Quiet).expect("an ensemble");
    let text = fs::read_to_string(decimals.join("final_states.csv")).expect("states");
    let columns = text.lines().next().expect("headings").split(',').count() - 1;
    let expected: Vec<f64> = (text.lines().skip(1))
        .flat_map(|line| line.split(',').skip(1))
        .map(|cell| cell.parse().unwrap_or(0.0))
        .collect();
    let bytes = fs::read(into.join("final_states.npy")).expect("a matrix");
    let (head, rest) = bytes.split_at(128);
    let shape = format!("'shape': (333, {columns})");
    assert!(String::from_utf8_lossy(head).contains(&shape), "{shape}");
    let found: Vec<f64> = (rest.chunks_exact(8))
        .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("8 bytes")))
        .collect();
    assert!(found == expected);
    let manifest = fs::read_to_string(into.join("manifest.json")).expect("a manifest");
    assert!(
        manifest.contains("\"file\": \"final_states.npy\""),
        "{manifest}"
    );
}

#[test]
fn crossings_and_losses_are_merged_too() {
    let text = BODY
        .replace("METHOD", METHODS[0])
        .replace("ENSEMBLE", MANY)
        .replace(
            "steps   = 43",
            "steps   = 43\nstop    = \"x1 > 1.15\"\nsection = { at = \"x1 = 1.02\", direction = \"both\" }",
        );
    let document = SceneDocument::parse("body.toml", &text, &Registry::empty()).expect("a scene");
    let root = tempfile::tempdir().expect("a directory");
    let whole = root.path().join("whole");
    let report = attempt(&document, &whole, workforce(2, 16), &mut Quiet).expect("an ensemble");
    let (stopped, crossings) = (report.reductions.stopped, report.crossings);
    assert!(
        stopped > 0 && crossings > Some(0),
        "{stopped} {crossings:?}"
    );
    let mut shards = Vec::new();
    for members in [192..333, 0..64, 64..192] {
        let one = Shard::between(Whole::Members, members, 333).expect("a shard");
        let directory = root.path().join(one.name());
        shard(&document, &one, &directory, workforce(1, 64), &mut Quiet).expect("a shard");
        shards.push(directory);
    }
    let into = root.path().join("merged");
    let joined = merged(&document, &shards, &into).expect("merged");
    assert_eq!(joined.crossings, report.crossings);
    is_same(&whole, &into, &FILES);
    is_same(&whole, &into, &["section.csv", "losses.csv"]);
}

#[test]
fn what_does_not_fit_together_is_refused_by_name() {
    let document = scene(METHODS[0], MANY);
    let root = tempfile::tempdir().expect("a directory");
    let make = |document: &SceneDocument, number: u64, folder: &str| {
        let one = Shard::of(Whole::Members, number, 3, 333).expect("a shard");
        let directory = root.path().join(folder).join(one.name());
        shard(document, &one, &directory, workforce(1, 64), &mut Quiet).expect("a shard");
        directory
    };
    let into = root.path().join("merged");
    let [first, third] = [1, 3].map(|number| make(&document, number, "own"));
    // One is missing.
    let error = merged(&document, &[first.clone(), third.clone()], &into).expect_err("missing");
    let MergeError::Missing(missing) = &error else {
        panic!("{error}");
    };
    assert_eq!(missing.items.first(), Some(&(128..256)));
    assert_eq!(missing.items.len(), 1);
    assert_eq!(missing.shards, Some((vec![[2, 2]], 3)));
    assert!(
        error.to_string().contains("--array=2 with --shard slurm/3"),
        "{error}"
    );
    // One is of another scene.
    let other = scene(METHODS[0], &MANY.replace("seed = 5", "seed = 6"));
    let strange = make(&other, 2, "other");
    let error =
        merged(&document, &[first.clone(), strange, third.clone()], &into).expect_err("other");
    assert!(
        error.to_string().contains("ensemble.seed: 5 → 6"),
        "{error}"
    );
    // One is there twice.
    let copy = make(&document, 1, "copy");
    let second = make(&document, 2, "own");
    let all = [first.clone(), copy, second.clone(), third.clone()];
    let error = merged(&document, &all, &into).expect_err("twice");
    assert!(matches!(error, MergeError::Twice { .. }), "{error}");
    // A file is cut short.
    let states = second.join("final_states.csv");
    let bytes = fs::read(&states).expect("states");
    fs::write(&states, &bytes[..bytes.len() - 1]).expect("written");
    let all = [first, second, third];
    let error = merged(&document, &all, &into).expect_err("damaged");
    assert!(error.to_string().contains("final_states.csv"), "{error}");
    // Put right again, what was left of the attempt is no hindrance.
    fs::write(&states, &bytes).expect("written");
    merged(&document, &all, &into).expect("merged");
    assert!(merged(&document, &all, &into).expect("merged").is_repeated);
    let error = merged(&document, &[root.path().join("nowhere")], &into).expect_err("nothing");
    assert!(matches!(error, MergeError::Run(_)), "{error}");
    let error = merged(&document, std::slice::from_ref(&into), &into).expect_err("no shard");
    assert!(matches!(error, MergeError::NoShard { .. }), "{error}");
}
