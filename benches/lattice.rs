//! Ten steps of the Volterra lattice, and of spins on planes and boxes, cost a time linear in the number of sites.

#![allow(clippy::print_stderr)]

use std::time::Instant;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use leafwise::core::Walk;
use leafwise_benches::{composed, lattice_scene};

const SITES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Steps from the initial wave in one measurement.
const STEPS: u64 = 10;

fn advance(mut walk: Walk) -> Walk {
    for _ in 0..STEPS {
        walk.step().expect("a step");
    }
    walk
}

/// Heisenberg's exchange over lattices of one, two and three axes with about 2.6·10⁵ spins each, without and with ends.
const SPINS: [(&[usize], &str); 5] = [
    (&[262_144], "periodic"),
    (&[512, 512], "periodic"),
    (&[512, 512], "open"),
    (&[64, 64, 64], "periodic"),
    (&[64, 64, 64], "open"),
];

/// The same at temperature: damping and noise at every site.
const HOT: [&[usize]; 3] = [&[262_144], &[512, 512], &[64, 64, 64]];

/// A spiral along the last axis, which steps as `method` says.
fn spins_scene(lengths: &[usize], boundary: &str, system: &str, method: &str) -> String {
    let indices = &["i", "j", "k"][..lengths.len()];
    let here = indices.join(",");
    let mut bonds = Vec::new();
    for axis in 0..indices.len() {
        let mut there: Vec<String> = indices.iter().map(|index| (*index).to_owned()).collect();
        there[axis].push_str("+1");
        let there = there.join(",");
        bonds.extend(["x", "y", "z"].map(|c| format!("s.{c}[{here}]*s.{c}[{there}]")));
    }
    let last = indices[indices.len() - 1];
    format!(
        "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {lengths:?} }} }}\n\
         boundary = \"{boundary}\"\nbracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"-sum({}, {})\"\n\
         {system}[method]\n{method}time-step = 0.05\n[run]\nsteps = 1\n[run.initial]\n\
         \"s.x[{here}]\" = \"0.6*cos(pi*{last}/8)\"\n\"s.y[{here}]\" = \"0.6*sin(pi*{last}/8)\"\n\"s.z[{here}]\" = 0.8\n",
        indices.join(", "),
        bonds.join(" + ")
    )
}

fn spins(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ten steps, Heisenberg spins");
    group.sample_size(10);
    for (lengths, boundary) in SPINS {
        let run = composed(&spins_scene(
            lengths,
            boundary,
            "",
            "stepper = \"splitting\"\n",
        ));
        let sites: usize = lengths.iter().product();
        group.throughput(Throughput::Elements(STEPS * sites as u64));
        group.bench_function(format!("{lengths:?} {boundary}"), |bencher| {
            bencher.iter_batched(|| run.walk(), advance, BatchSize::PerIteration);
        });
    }
    group.finish();
}

/// Channels of noise at temperature 1/2, for a damping of 1/10.
fn bath(lengths: &[usize]) -> String {
    let here = &"i,j,k"[..2 * lengths.len() - 1];
    let channel = |c| format!("{{ hamiltonian = \"s.{c}[{here}]\", strength = \"sqrt(0.1)\" }}");
    let channels = ["x", "y", "z"].map(channel).join(", ");
    format!("damping = {{ rate = 0.1 }}\nnoise = [{channels}]\n")
}

fn hot(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ten steps, hot Heisenberg spins");
    group.sample_size(10);
    for lengths in HOT {
        let sites: usize = lengths.iter().product();
        group.throughput(Throughput::Elements(STEPS * sites as u64));
        for (name, stepper) in [
            ("sublattices", "stepper = \"sublattices\"\n"),
            ("one-form", ""),
        ] {
            let method = format!("{stepper}noise = \"split\"\n");
            let run = composed(&spins_scene(lengths, "periodic", &bath(lengths), &method));
            group.bench_function(format!("{lengths:?} {name}"), |bencher| {
                bencher.iter_batched(|| run.walk(), advance, BatchSize::PerIteration);
            });
        }
    }
    group.finish();
}

fn lattice(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ten steps, Volterra lattice");
    group.sample_size(10);
    for sites in SITES {
        let started = Instant::now();
        let run = composed(&lattice_scene(sites));
        let built = started.elapsed();
        eprintln!("N = {sites}: built in {:.1} ms", built.as_secs_f64() * 1e3);
        group.throughput(Throughput::Elements(STEPS * sites as u64));
        group.bench_function(format!("N={sites}"), |bencher| {
            bencher.iter_batched(|| run.walk(), advance, BatchSize::PerIteration);
        });
        let statistics = advance(run.walk()).statistics();
        eprintln!(
            "  {:.2} evaluations a step",
            statistics.evaluations_per_step()
        );
    }
    group.finish();
}

criterion_group!(benches, lattice, spins, hot);
criterion_main!(benches);
