//! Step kernels by the interpreter and as machine code: nanoseconds an evaluation and their ratio,
//! for one lane and for eight, and how much of a step its kernel takes.

#![allow(clippy::print_stdout)]

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use leafwise::expression::{Execution, Kernel};
use leafwise_benches::{HEAVY_TOP, PERIODIC_LOTKA_VOLTERRA, RIGID_BODY, composed, scene_with};

/// Nanoseconds a call: the best of several rounds.
fn nanoseconds(calls: usize, mut call: impl FnMut()) -> f64 {
    (0..7)
        .map(|_| {
            let start = Instant::now();
            (0..calls).for_each(|_| call());
            start.elapsed().as_secs_f64() / calls as f64 * 1e9
        })
        .fold(f64::INFINITY, f64::min)
}

fn evaluation(kernel: &Kernel, execution: Execution, lanes: usize, state: &[f64]) -> f64 {
    let mut workspace = kernel.workspace_for(lanes, execution);
    let parameters = vec![1.0; kernel.parameters() * lanes];
    let sizes = vec![0.1; lanes];
    kernel.prepare(&mut workspace, &parameters, &sizes, &sizes);
    for (i, x) in state.iter().enumerate() {
        workspace.input_mut(i).fill(*x);
    }
    let calls = 1 + 2_000_000 / (kernel.step_operations().total() * lanes + 100);
    nanoseconds(calls, || {
        kernel.evaluate_in_place(black_box(&mut workspace));
    })
}

fn main() {
    let so3 = "{ name = \"so3-exponential\" }";
    let truncated = |n: usize| format!("{{ name = \"karasev-truncated\", order = {n} }}");
    let cases = [
        (
            "rigid body, so3-exponential, m=2",
            RIGID_BODY,
            so3.to_owned(),
            2,
            0.1,
        ),
        (
            "rigid body, so3-exponential, m=4",
            RIGID_BODY,
            so3.to_owned(),
            4,
            0.1,
        ),
        (
            "rigid body, so3-exponential, m=8",
            RIGID_BODY,
            so3.to_owned(),
            8,
            0.1,
        ),
        ("rigid body, n=2 m=2", RIGID_BODY, truncated(2), 2, 0.1),
        ("rigid body, n=10 m=8", RIGID_BODY, truncated(10), 8, 0.1),
        ("heavy top, n=4 m=4", HEAVY_TOP, truncated(4), 4, 0.05),
        ("heavy top, n=6 m=6", HEAVY_TOP, truncated(6), 6, 0.05),
        (
            "periodic Lotka-Volterra, log-canonical, m=4",
            PERIODIC_LOTKA_VOLTERRA,
            "{ name = \"log-canonical\" }".to_owned(),
            4,
            0.05,
        ),
        (
            "periodic Lotka-Volterra, n=4 m=4",
            PERIODIC_LOTKA_VOLTERRA,
            truncated(4),
            4,
            0.05,
        ),
        (
            "periodic Lotka-Volterra, n=8 m=4",
            PERIODIC_LOTKA_VOLTERRA,
            truncated(8),
            4,
            0.05,
        ),
    ];
    let mut table = String::from(
        "| kernel | operations | lanes | interpreter ns | machine code ns | ratio | ns/operation | compile ms | bytes |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut steps = String::from(
        "| method | step, interpreter ns | step, machine code ns | ratio | evaluations | in the kernel |\n|---|---|---|---|---|---|\n",
    );
    for (name, (library, initial), realization, m, time_step) in cases {
        let text = scene_with(library, initial, &realization, m, time_step);
        let run = composed(&text);
        let method = run.method.written().expect("a written method");
        let kernel = method.newton().expect("one kernel").kernel();
        let operations = kernel.step_operations().total();
        let mut single = 0.0;
        for lanes in [1, 8] {
            let interpreted = evaluation(kernel, Execution::Interpreted, lanes, &run.plan.initial);
            let compiled = evaluation(kernel, Execution::Compiled, lanes, &run.plan.initial);
            let size = kernel
                .machine_code()
                .into_iter()
                .find(|size| size.lanes == lanes);
            let (seconds, bytes) = size.map_or((f64::NAN, 0), |size| (size.seconds, size.bytes));
            if lanes == 1 {
                single = compiled;
            }
            writeln!(
                table,
                "| {name} | {operations} | {lanes} | {interpreted:.0} | {compiled:.0} | {:.1} | {:.2} | {:.2} | {bytes} |",
                interpreted / compiled,
                compiled / (operations * lanes) as f64,
                seconds * 1e3,
            )
            .expect("a string");
        }
        let step = |execution: Execution| {
            execution.set_default_of_process();
            let run = composed(&text);
            let mut integrator = run.integrator();
            (0..3000).for_each(|_| integrator.step().expect("a step"));
            let time = nanoseconds(500, || integrator.step().expect("a step"));
            (time, integrator.statistics().evaluations_per_step())
        };
        let (interpreted, _) = step(Execution::Interpreted);
        let (compiled, evaluations) = step(Execution::Compiled);
        Execution::default().set_default_of_process();
        writeln!(
            steps,
            "| {name} | {interpreted:.0} | {compiled:.0} | {:.1} | {evaluations:.2} | {:.0} % |",
            interpreted / compiled,
            100.0 * single * evaluations / compiled,
        )
        .expect("a string");
    }
    println!("{table}\n{steps}");
}
