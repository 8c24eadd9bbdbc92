//! The cost of one step by order and system.

use criterion::{Criterion, criterion_group, criterion_main};
use leafwise_benches::{HEAVY_TOP, PERIODIC_LOTKA_VOLTERRA, RIGID_BODY, composed, scene};

fn step(criterion: &mut Criterion) {
    let cases = [
        ("rigid body", RIGID_BODY, [(2, 2), (6, 2), (6, 4), (10, 8)]),
        ("heavy top", HEAVY_TOP, [(2, 2), (6, 2), (6, 4), (6, 6)]),
        (
            "periodic Lotka-Volterra",
            PERIODIC_LOTKA_VOLTERRA,
            [(2, 2), (4, 4), (6, 4), (8, 8)],
        ),
    ];
    for (name, (library, initial), orders) in cases {
        let mut group = criterion.benchmark_group(format!("one step, {name}"));
        group.sample_size(20);
        for (n, m) in orders {
            let run = composed(&scene(library, initial, n, m, 0.05));
            let mut walk = run.walk();
            group.bench_function(format!("n={n} m={m}"), |bencher| {
                bencher.iter(|| walk.step().expect("a step"));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, step);
criterion_main!(benches);
