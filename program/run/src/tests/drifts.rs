//! Drifts that are looked at every so many steps.

use std::fs;

use super::{SCENE, StopAfter, attempt};
use crate::RunOutcome;

/// The largest deviation among the energies of a table, of every so many steps and the last.
fn largest(samples: &str, every: usize) -> f64 {
    let energies: Vec<f64> = samples
        .lines()
        .skip(1)
        .map(|row| {
            row.split(',')
                .nth(4)
                .expect("a cell")
                .parse()
                .expect("a number")
        })
        .collect();
    let last = energies.len() - 1;
    let deviations = energies.iter().enumerate();
    let looked_at = deviations.filter(|(step, _)| *step == last || step.is_multiple_of(every));
    looked_at.fold(0.0, |most, (_, energy)| {
        (energy - energies[0]).abs().max(most)
    })
}

/// Steps that are made many at a time, those that are watched one by one, and those of several sessions: the largest of the
/// steps that are looked at, and of no other.
#[test]
fn drifts_are_the_largest_of_the_steps_that_are_looked_at() {
    let root = tempfile::tempdir().expect("a directory");
    let of = |every: usize, more: &str, sessions: u32| {
        let record = format!("record  = {{ every = 1, drift-every = {every},");
        let scene = SCENE
            .replace("steps   = 20000", "steps   = 833")
            .replace("record  = { every = 7,", &record)
            + more;
        let path = root.path().join(format!("{every}{}{sessions}", more.len()));
        let report = loop {
            let report = attempt(&scene, &path, false, &mut StopAfter(sessions)).expect("a run");
            if report.outcome == RunOutcome::Done {
                break report;
            }
        };
        let samples = fs::read_to_string(path.join("samples.csv")).expect("samples");
        (report.invariants[0].maximum, largest(&samples, every))
    };
    let mut found = Vec::new();
    for every in [1, 2, 7, 64, 100, 833, 5000] {
        let (drift, expected) = of(every, "", u32::MAX);
        assert!(expected > 0.0);
        assert_eq!(drift, expected, "{every}");
        assert_eq!(of(every, "stop = \"x1 > 100\"\n", u32::MAX).0, expected);
        assert_eq!(of(every, "", 2).0, expected);
        found.push(expected);
    }
    // A look at fewer steps sees less.
    assert!(found[3] < found[0] && found[6] < found[0], "{found:?}");
}
