//! Ensembles of rigid bodies to T = 200: trajectories a second at a measured error, by `leafwise ensemble`
//! as users run it, against hand-written code of the same method over the same lanes and threads.

#![allow(clippy::print_stdout)]

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use leafwise::core::{Registry, Walk};
use leafwise::run::ensemble::{ComposedEnsemble, EnsembleJob, Workforce, compose_ensemble};
use leafwise::run::shards::Portion;
use leafwise::run::{Quiet, perform};
use leafwise::scene::SceneDocument;
use leafwise_benches::options;
use leafwise_benches::rotations::{Composition, rigid_bodies};

/// The time of every run.
const TIME: f64 = 200.0;

const MEMBERS: usize = 10_000;

/// Members whose error is measured.
const MEASURED: usize = 64;

const LANES: usize = 64;

fn scene(method: &str, time_step: f64) -> String {
    let steps = (TIME / time_step).round();
    format!(
        "[system]\nlibrary = \"rigid-body\"\n[method]\n{method}\ntime-step = {time_step:?}\n\
         [run]\ninitial = [1, 3, 3]\nsteps = {steps}\n\
         [ensemble]\nmembers = {MEMBERS}\nseed = 1\ninitial = {{ ball = 0.1 }}\n\
         record = {{ drift-every = {steps} }}\nfinal-states = \"binary\"\n"
    )
}

fn composed(method: &str, time_step: f64) -> (SceneDocument, ComposedEnsemble) {
    let text = scene(method, time_step);
    let document =
        SceneDocument::parse("bench.toml", &text, &Registry::with_builtin()).expect("a scene");
    let ensemble = compose_ensemble(&document, &Registry::with_builtin(), Path::new(""));
    (document, ensemble.expect("an ensemble"))
}

/// Seconds of integration, and the measured members' last states.
fn run(method: &str, time_step: f64, threads: usize) -> (f64, Vec<f64>) {
    let (document, ensemble) = composed(method, time_step);
    let directory = std::env::temp_dir().join(format!("leafwise-bench-{}", std::process::id()));
    let count = |n| NonZeroUsize::new(n).expect("positive");
    let workforce = Workforce {
        threads: count(threads),
        lanes: count(LANES),
    };
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let options = options(&directory);
        let all = Portion::default();
        let job = EnsembleJob::new(&document, &ensemble, all, &options, workforce);
        let report = job.and_then(|job| perform(&job, &mut Quiet));
        best = best.min(report.expect("an ensemble").wall_seconds);
    }
    let bytes = std::fs::read(directory.join("final_states.bin")).expect("states");
    let _ = std::fs::remove_dir_all(&directory);
    let (numbers, _) = bytes.as_chunks::<8>();
    let states = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes));
    (best, states.take(3 * MEASURED).collect())
}

/// The last states of the measured members by another method: its own error is that of half the steps.
fn reference() -> (Vec<f64>, f64) {
    let at = |time_step: f64| {
        let method = "realization = \"so3-exponential\"\n\
                      dynamics = { name = \"hamilton-jacobi\", order = 8 }";
        let (_, ensemble) = composed(method, time_step);
        let mut states = Vec::new();
        for member in 0..MEASURED as u64 {
            let (initial, parameters) = ensemble.population.draw(member).expect("a member");
            let map = ensemble.run.method.map();
            let mut one = Walk::new(map, &parameters, 1.0, time_step, &initial);
            for _ in 0..ensemble.run.plan.steps {
                one.step().expect("a step");
            }
            states.extend(one.last(0).1);
        }
        states
    };
    let (coarse, fine) = (at(0.04), at(0.02));
    let error = distance(&coarse, &fine);
    (fine, error)
}

/// The largest distance between two members.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let members = a.chunks(3).zip(b.chunks(3));
    let square =
        |(a, b): (&[f64], &[f64])| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
    libm::sqrt(members.map(square).fold(0.0, f64::max))
}

/// The hand-written code on the same members; seconds, and the measured members' last states.
fn by_hand(composition: &Composition, time_step: f64, threads: usize) -> (f64, Vec<f64>) {
    let (_, ensemble) = composed("stepper = \"splitting\"", time_step);
    let members: Vec<Vec<f64>> = (0..MEMBERS as u64)
        .map(|member| ensemble.population.draw(member).expect("a member").0)
        .collect();
    let inertia = ensemble.run.system.parameter_values();
    let steps = ensemble.run.plan.steps;
    let blocks: Vec<&[Vec<f64>]> = members.chunks(LANES).collect();
    let mut best = f64::INFINITY;
    let mut states = Vec::new();
    for _ in 0..3 {
        let started = Instant::now();
        let next = AtomicUsize::new(0);
        let work = || {
            let mut first = Vec::new();
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(block) = blocks.get(at) else {
                    return first;
                };
                let mut x = [[0.0; LANES]; 3];
                for (lane, member) in block.iter().enumerate() {
                    (0..3).for_each(|i| x[i][lane] = member[i]);
                }
                rigid_bodies(&mut x, &inertia, composition, time_step, steps);
                if at == 0 {
                    first = (0..3 * MEASURED).map(|at| x[at % 3][at / 3]).collect();
                }
            }
        };
        let found: Vec<Vec<f64>> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            let results = workers
                .into_iter()
                .map(|worker| worker.join().expect("no panic"));
            results.collect()
        });
        best = best.min(started.elapsed().as_secs_f64());
        states = found
            .into_iter()
            .find(|states| !states.is_empty())
            .expect("a first block");
    }
    (best, states)
}

fn main() {
    let threads = std::thread::available_parallelism()
        .map_or(1, NonZeroUsize::get)
        .min(2);
    let (truth, error) = reference();
    println!(
        "{MEMBERS} rigid bodies from a ball of radius 0.1 about (1, 3, 3) to t = {TIME} on {threads} \
         threads;\nerrors: the largest of {MEASURED} members, against a reference good to {error:.1e}"
    );
    let rate = |seconds: f64| MEMBERS as f64 / seconds;
    for composition in Composition::all() {
        for &time_step in composition.time_steps {
            let method = match composition.name {
                "none" => "stepper = \"splitting\"".to_owned(),
                name => format!("stepper = \"splitting\"\ncomposition = \"{name}\""),
            };
            let (seconds, states) = run(&method, time_step, threads);
            let (hand, by_hand) = by_hand(&composition, time_step, threads);
            println!(
                "splitting, composition {:15} t = {time_step:6}: {:8.0} members/s, error {:.1e}; by \
                 hand {:8.0} members/s, error {:.1e}; {:.2} times the time by hand",
                composition.name,
                rate(seconds),
                distance(&states, &truth),
                rate(hand),
                distance(&by_hand, &truth),
                seconds / hand,
            );
        }
    }
    for order in [4, 8] {
        let method = format!(
            "realization = \"so3-exponential\"\ndynamics = {{ name = \"hamilton-jacobi\", order = {order} }}"
        );
        let time_step = if order == 4 { 0.05 } else { 0.2 };
        let (seconds, states) = run(&method, time_step, threads);
        println!(
            "so3-exponential, hamilton-jacobi {order}, t = {time_step}: {:8.0} members/s, error {:.1e}",
            rate(seconds),
            distance(&states, &truth),
        );
    }
}
