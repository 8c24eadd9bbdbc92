//! An ensemble: many initial states at once, reduced to statistics.
//!
//! The scene's `[ensemble]` table draws the members; they are stepped side by side on all threads, to
//! the same bits whatever their number, into a run directory with a report.

#![allow(clippy::print_stdout, reason = "a lesson prints")]

use leafwise::prelude::*;
use leafwise::run::ensemble::{EnsembleJob, Workforce, compose_ensemble};
use leafwise::run::shards::Portion;
use leafwise::run::{Quiet, RunOptions, perform};

const SCENE: &str = r#"
    [system]
    library = "rigid-body"
    [method]
    stepper   = "splitting"
    time-step = 0.05
    [run]
    initial = [1, 3, 3]
    steps   = 200
    [ensemble]
    members = 500
    seed    = 1
    initial = { leaf = 0.1 }
    record  = { every = 200, observables = ["spin", "x1"] }
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("spinning", SCENE, &registry)?;
    let ensemble = compose_ensemble(&document, &registry, ".".as_ref())?;
    let directory = std::env::temp_dir().join(format!("leafwise-04-{}", std::process::id()));
    let options = RunOptions {
        force: true,
        command: "cargo run --example 04_ensemble".to_owned(),
        ..RunOptions::within(&directory)
    };
    let (all, workforce) = (Portion::default(), Workforce::default());
    let job = EnsembleJob::new(&document, &ensemble, all, &options, workforce)?;
    let report = perform(&job, &mut Quiet)?;
    std::fs::remove_dir_all(directory)?;

    let reductions = &report.reductions;
    println!(
        "{} members, {} failed",
        reductions.members, reductions.failed
    );
    // Observables at the first time, then at the second.
    for (name, summary) in ["spin", "x1"].iter().cycle().zip(&reductions.summaries) {
        println!(
            "{name}: mean {:.6} ± {:.1e}",
            summary.mean,
            summary.deviation()
        );
    }
    // All members began on the leaf |x|² = 19, and all are there still.
    let spin = &reductions.summaries[2];
    assert!((spin.mean - 19.0).abs() < 1e-12 && spin.deviation() < 1e-12);
    Ok(())
}
