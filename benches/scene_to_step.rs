//! From scene text to the first step: parsing, exact algebra, code, one cold solve.

use criterion::{Criterion, criterion_group, criterion_main};
use leafwise_benches::{HEAVY_TOP, RIGID_BODY, composed, lattice_scene, scene};

fn to_first_step(text: &str) -> f64 {
    let run = composed(text);
    let mut walk = run.walk();
    walk.step().expect("a step");
    walk.state()[0]
}

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("scene to first step");
    group.sample_size(10);
    let cases = [
        (
            "rigid body n=2 m=2",
            scene(RIGID_BODY.0, RIGID_BODY.1, 2, 2, 0.1),
        ),
        (
            "rigid body n=10 m=8",
            scene(RIGID_BODY.0, RIGID_BODY.1, 10, 8, 0.1),
        ),
        (
            "heavy top n=6 m=8",
            scene(HEAVY_TOP.0, HEAVY_TOP.1, 6, 8, 0.1),
        ),
        ("Volterra lattice N=10^3", lattice_scene(1_000)),
        ("Volterra lattice N=10^6", lattice_scene(1_000_000)),
    ];
    for (name, text) in &cases {
        group.bench_function(*name, |bencher| bencher.iter(|| to_first_step(text)));
    }
    group.finish();
}

criterion_group!(benches, build);
criterion_main!(benches);
