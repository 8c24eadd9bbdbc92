//! What a run costs beside its bare steps, and a row of its table.

use std::hint::black_box;

use leafwise::core::Registry;
use leafwise::run::{Quiet, RunJob, perform};
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_benches::options;

use crate::accuracy::ratio;
use crate::document::{Table, time};
use crate::measure::{Times, alternating};

const ROUNDS: usize = 9;

/// Coordinates that are stepped in one sample.
const COORDINATES: u64 = 1_500_000;

/// A system with a method: its name, its scene without `[run]`, and where it begins.
const CASES: [(&str, &str, &str); 7] = [
    (
        "rigid body, Hamilton–Jacobi 8",
        "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"so3-exponential\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 8 }\ntime-step = 0.1\n",
        "[1, 3, 3]",
    ),
    (
        "rigid body, splitting",
        "[system]\nlibrary = \"rigid-body\"\n[method]\nstepper = \"splitting\"\ncomposition = \"blanes-moan-6\"\n\
         time-step = 0.1\n",
        "[1, 3, 3]",
    ),
    (
        "rigid body, Gauss of 8 stages",
        "[system]\nlibrary = \"rigid-body\"\n[method]\nrealization = \"clebsch\"\n\
         dynamics = { name = \"collective\", integrator = \"gauss\", stages = 8 }\ntime-step = 0.4\n",
        "[1, 3, 3]",
    ),
    (
        "Lotka–Volterra, Hamilton–Jacobi 8",
        "[system]\nlibrary = \"lotka-volterra-periodic\"\n[method]\nrealization = \"log-canonical\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 8 }\ntime-step = 0.05\n",
        "[1, 1.9, 0.5]",
    ),
    (
        "heavy top, Hamilton–Jacobi 4",
        "[system]\nlibrary = \"heavy-top\"\n[method]\nrealization = \"lie-poisson\"\n\
         dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.05\n",
        "[0.5, -0.4, 1.2, 0.6, 0.0, 0.8]",
    ),
    (
        "Volterra lattice of 1000 sites, splitting",
        "[system]\nlibrary = \"volterra-lattice\"\nfamilies = { x = 1000 }\n[method]\n\
         stepper = \"splitting\"\ncomposition = \"blanes-moan-4\"\ntime-step = 0.1\n",
        "{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }",
    ),
    (
        "Volterra lattice of 100000 sites, splitting",
        "[system]\nlibrary = \"volterra-lattice\"\nfamilies = { x = 100000 }\n[method]\n\
         stepper = \"splitting\"\ncomposition = \"blanes-moan-4\"\ntime-step = 0.1\n",
        "{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }",
    ),
];

/// Steps from one look at the drifts to the next, where they are looked at rarely.
const RARELY: u64 = 64;

/// A scene of so many steps, with a record and a look at the drifts every so many.
fn scene(
    system: &str,
    initial: &str,
    steps: u64,
    (every, drift_every): (u64, u64),
) -> (SceneDocument, ComposedRun) {
    let text = format!(
        "{system}[run]\ninitial = {initial}\nsteps = {steps}\n\
         record = {{ every = {every}, drift-every = {drift_every} }}\n"
    );
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("bench.toml", &text, &registry).expect("a scene");
    let run = compose(&document, &registry).expect("a method");
    (document, run)
}

/// Seconds of the steps of a run into a directory, all that it looks at and records with them.
fn whole(document: &SceneDocument, composed: &ComposedRun) -> f64 {
    let directory =
        std::env::temp_dir().join(format!("leafwise-bench-walk-{}", std::process::id()));
    let (registry, options) = (Registry::with_builtin(), options(&directory));
    let job = RunJob::new(document, composed, &registry, &options);
    let report = job.and_then(|job| perform(&job, &mut Quiet));
    let _ = std::fs::remove_dir_all(&directory);
    report.expect("a run").wall_seconds
}

/// The table of all cases.
pub fn table() -> String {
    let mut table = Table::new(&[
        "system and method",
        "a bare step",
        "a step of a run",
        "ratio",
        "drifts every 64 steps",
        "a row of `samples.csv`",
    ]);
    for (name, system, initial) in CASES {
        let dimension = scene(system, initial, 1, (1, 1)).1.dimension() as u64;
        let steps = (COORDINATES / dimension).max(20);
        let (document, composed) = scene(system, initial, steps, (steps, 1));
        let (rarely, rare_run) = scene(system, initial, steps, (steps, RARELY));
        let (recorded, recorded_run) = scene(system, initial, steps, (1, 1));
        let bare = || {
            let mut walk = composed.walk();
            let started = std::time::Instant::now();
            walk.advance(steps).expect("steps");
            let seconds = started.elapsed().as_secs_f64();
            black_box(walk.state());
            seconds
        };
        let has_rows = dimension <= 12;
        let rows = || match has_rows {
            true => whole(&recorded, &recorded_run),
            false => 0.0,
        };
        let times: Times = alternating(
            &mut [
                Box::new(bare),
                Box::new(|| whole(&document, &composed)),
                Box::new(|| whole(&rarely, &rare_run)),
                Box::new(rows),
            ],
            ROUNDS,
        );
        let a_step = |at: usize| times.seconds(at).low / steps as f64;
        table.row(&[
            name.to_owned(),
            time(a_step(0)),
            time(a_step(1)),
            ratio(times.ratio(1, 0)),
            ratio(times.ratio(2, 0)),
            match has_rows {
                true => time(a_step(3) - a_step(1)),
                false => "—".to_owned(),
            },
        ]);
    }
    table.finish()
}
