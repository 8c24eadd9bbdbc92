//! Ten steps of the Volterra lattice cost a time linear in the number of sites.

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

criterion_group!(benches, lattice);
criterion_main!(benches);
