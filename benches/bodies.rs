//! Steps of bodies whose H is a sum over pairs: a time in proportion to the pairs, and none to compose.
//!
//! The throughput is in pairs and stages: a reciprocal of 1 Gelem/s is 1 ns a pair and stage.

#![allow(clippy::print_stderr)]

use std::time::Instant;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use leafwise::core::Walk;
use leafwise_benches::composed;

/// Steps in one measurement.
const STEPS: u64 = 10;

fn advance(mut walk: Walk) -> Walk {
    for _ in 0..STEPS {
        walk.step().expect("a step");
    }
    walk
}

/// Softened gravity in space.
fn gravity(sites: usize, method: &str) -> String {
    let families = ["x", "y", "z", "u", "v", "w"].map(|name| format!("{name} = {sites}"));
    format!(
        "[system]\nfamilies = {{ {} }}\nconvention = \"{{x,H}}\"\n\
         bracket = {{ \"x[i],u[i]\" = \"N\", \"y[i],v[i]\" = \"N\", \"z[i],w[i]\" = \"N\" }}\n\
         hamiltonian = \"sum(i, u[i]^2 + v[i]^2 + w[i]^2)/(2*N) \
         - sum(i<j, 1/sqrt((x[i] - x[j])^2 + (y[i] - y[j])^2 + (z[i] - z[j])^2 + 0.01))/N^2\"\n\
         [method]\n{method}\ntime-step = 0.001\n[run]\nsteps = 1\n[run.initial]\n\
         \"x[i]\" = \"sin(1.3*i)\"\n\"y[i]\" = \"cos(2.1*i)\"\n\"z[i]\" = \"sin(0.7*i + 1)\"\n\
         \"u[i]\" = \"0.2*cos(1.1*i)\"\n\"v[i]\" = \"0.2*sin(3.1*i)\"\n\"w[i]\" = \"0.1*cos(i)\"\n",
        families.join(", ")
    )
}

/// Point vortices of one circulation on a ring.
fn vortices(sites: usize, method: &str) -> String {
    vortices_on(sites, method, ["1/(4*pi)", "1", "0.001"])
}

/// The same of another strength on a ring whose radius is a formula of i, in steps of this length.
fn vortices_on(sites: usize, method: &str, [strength, radius, time_step]: [&str; 3]) -> String {
    format!(
        "[system]\nfamilies = {{ x = {sites}, y = {sites} }}\nconvention = \"{{x,H}}\"\n\
         bracket = {{ \"x[i],y[i]\" = \"1\" }}\n\
         hamiltonian = \"-{strength}*sum(i<j, ln((x[i] - x[j])^2 + (y[i] - y[j])^2))\"\n\
         [method]\n{method}\ntime-step = {time_step}\n[run]\nsteps = 1\n[run.initial]\n\
         \"x[i]\" = \"({radius})*cos(2*pi*i/N)\"\n\"y[i]\" = \"({radius})*sin(2*pi*i/N)\"\n"
    )
}

/// A ring of 30 that is not round: w = ½/r² moves it by about a tenth of its distances in a step.
const UNEVEN: [&str; 3] = ["-1/4", "sqrt(N)*(1 + 0.1*sin(6*pi*i/N))", "0.1"];

/// A name, the scene of so many bodies by a method, and the numbers of bodies.
type Kind = (&'static str, fn(usize, &str) -> String, &'static [usize]);

const KINDS: [Kind; 2] = [
    ("gravity", gravity, &[100, 300, 1000]),
    ("vortices", vortices, &[30, 300, 1000]),
];

fn bodies(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ten steps of rk4, bodies");
    group.sample_size(10);
    for (name, scene, numbers) in KINDS {
        for &sites in numbers {
            let started = Instant::now();
            let run = composed(&scene(sites, "stepper = \"rk4\""));
            let built = started.elapsed();
            eprintln!(
                "{name}, N = {sites}: built in {:.1} ms",
                built.as_secs_f64() * 1e3
            );
            let pairs = (sites * (sites - 1) / 2) as u64;
            // Four stages a step.
            group.throughput(Throughput::Elements(4 * STEPS * pairs));
            group.bench_function(format!("{name} N={sites}"), |bencher| {
                bencher.iter_batched(|| run.walk(), advance, BatchSize::PerIteration);
            });
        }
    }
    group.finish();
    // One evaluation of all pairs a step.
    let mut group = criterion.benchmark_group("ten steps of splitting, bodies");
    group.sample_size(10);
    let run = composed(&gravity(1000, "stepper = \"splitting\""));
    group.throughput(Throughput::Elements(STEPS * 1000 * 999 / 2));
    group.bench_function("gravity N=1000", |bencher| {
        bencher.iter_batched(|| run.walk(), advance, BatchSize::PerIteration);
    });
    group.finish();
    let mut group = criterion.benchmark_group("ten steps of Gauss, vortices");
    group.sample_size(10);
    for stages in [3, 8] {
        let method = format!("stepper = {{ name = \"gauss\", stages = {stages} }}");
        let run = composed(&vortices_on(30, &method, UNEVEN));
        group.throughput(Throughput::Elements(STEPS));
        group.bench_function(format!("N=30, {stages} stages"), |bencher| {
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

criterion_group!(benches, bodies);
criterion_main!(benches);
