//! From the text of a scene to its first step.

use std::hint::black_box;

use leafwise::expression::Execution;
use leafwise_benches::{
    HEAVY_TOP, PERIODIC_LOTKA_VOLTERRA, RIGID_BODY, composed, lattice_scene, scene, scene_with,
};

use crate::document::{Table, time};
use crate::measure::{Quartiles, Run, interleaved};

const ROUNDS: usize = 21;

/// The table; kernels run as a run of the program starts them, by the interpreter.
pub fn table() -> String {
    Execution::Adaptive.set_default_of_process();
    let exact = |problem: (&str, &str), realization: &str, m| {
        let realization = format!("{{ name = \"{realization}\" }}");
        scene_with(problem.0, problem.1, &realization, m, 0.1)
    };
    let cases = [
        (
            "rigid body, so3-exponential + HJ 8",
            exact(RIGID_BODY, "so3-exponential", 8),
        ),
        (
            "rigid body, karasev-truncated 8 + HJ 8",
            scene(RIGID_BODY.0, RIGID_BODY.1, 8, 8, 0.1),
        ),
        (
            "rigid body, so3-exponential + HJ 12",
            exact(RIGID_BODY, "so3-exponential", 12),
        ),
        (
            "periodic Lotka–Volterra, log-canonical + HJ 8",
            exact(PERIODIC_LOTKA_VOLTERRA, "log-canonical", 8),
        ),
        (
            "heavy top, lie-poisson + HJ 4",
            exact(HEAVY_TOP, "lie-poisson", 4),
        ),
        (
            "heavy top, lie-poisson + HJ 8",
            exact(HEAVY_TOP, "lie-poisson", 8),
        ),
        (
            "Volterra lattice, N = 10⁶, karasev-truncated 2 + HJ 2",
            lattice_scene(1_000_000),
        ),
    ];
    let mut runs: Vec<Run<'_>> = cases
        .iter()
        .map(|(_, text)| -> Run<'_> {
            Box::new(move || {
                let run = composed(text);
                let mut walk = run.walk();
                walk.step().expect("a step");
                black_box(walk.state());
            })
        })
        .collect();
    let times = interleaved(&mut runs, ROUNDS);
    drop(runs);
    Execution::Compiled.set_default_of_process();
    let mut table = Table::new(&["scene", "scene to first step", "quartiles"]);
    for (at, (name, _)) in cases.iter().enumerate() {
        let Quartiles { low, median, high } = times.seconds(at);
        table.row(&[
            (*name).to_owned(),
            time(median),
            format!("{}–{}", time(low), time(high)),
        ]);
    }
    table.finish()
}
