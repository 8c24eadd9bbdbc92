//! Step kernels by the interpreter and as machine code: nanoseconds an evaluation and their ratio,
//! for one lane and for eight, and how much of a step its kernel takes. Then coefficients likewise, and how long it takes to
//! make a stepper of one lane.

#![allow(clippy::print_stdout)]

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use leafwise::core::StepMap;
use leafwise::expression::{Execution, Kernel};
use leafwise::scene::ComposedRun;
use leafwise_benches::{
    HEAVY_TOP, PERIODIC_LOTKA_VOLTERRA, RIGID_BODY, composed, scene_of, scene_with,
};

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

/// Nanoseconds to form the coefficients.
fn preparation(kernel: &Kernel, execution: Execution, lanes: usize) -> f64 {
    let mut workspace = kernel.workspace_for(lanes, execution);
    let parameters = vec![1.25; kernel.parameters() * lanes];
    let sizes = vec![0.1; lanes];
    let calls = 1 + 2_000_000 / (kernel.coefficient_operations().total() * lanes + 100);
    nanoseconds(calls, || {
        kernel.prepare(black_box(&mut workspace), &parameters, &sizes, &sizes);
    })
}

/// A row for one lane and one for eight.
fn coefficients(name: &str, run: &ComposedRun, table: &mut String) {
    let method = run.method.written().expect("a written method");
    let kernel = method.newton().expect("one kernel").kernel();
    let parameters = run.system.parameter_values();
    for lanes in [1, 8] {
        let [interpreted, compiled] = [Execution::Interpreted, Execution::Compiled]
            .map(|execution| preparation(kernel, execution, lanes));
        let steppers = [Execution::Interpreted, Execution::Compiled].map(|execution| {
            execution.set_default_of_process();
            nanoseconds(200, || {
                black_box(method.stepper(1, &parameters, 1.0, 0.1));
            })
        });
        Execution::default().set_default_of_process();
        let stepper = match lanes {
            1 => format!("{:.1} | {:.1}", steppers[0] / 1e3, steppers[1] / 1e3),
            _ => " | ".to_owned(),
        };
        writeln!(
            table,
            "| {name} | {} | {lanes} | {:.2} | {:.2} | {stepper} |",
            kernel.coefficient_operations().total(),
            interpreted / 1e3,
            compiled / 1e3,
        )
        .expect("a string");
    }
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
            let mut walk = run.walk();
            (0..3000).for_each(|_| walk.step().expect("a step"));
            let time = nanoseconds(500, || walk.step().expect("a step"));
            (time, walk.statistics().evaluations_per_step())
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
    let mut prepared = String::from(
        "| coefficients | operations | lanes | interpreter µs | machine code µs | a stepper, interpreter µs | machine code µs |\n|---|---|---|---|---|---|---|\n",
    );
    let energy_casimir =
        "{ name = \"hamilton-jacobi\", order = 10, hamiltonian = \"energy-casimir\" }".to_owned();
    let given = |m: usize| format!("{{ name = \"hamilton-jacobi\", order = {m} }}");
    for (name, (library, initial), realization, dynamics) in [
        (
            "rigid body, so3-exponential, m=10, energy-casimir",
            RIGID_BODY,
            so3.to_owned(),
            energy_casimir,
        ),
        ("rigid body, n=8 m=8", RIGID_BODY, truncated(8), given(8)),
        ("heavy top, n=8 m=8", HEAVY_TOP, truncated(8), given(8)),
        (
            "periodic Lotka-Volterra, log-canonical, m=12",
            PERIODIC_LOTKA_VOLTERRA,
            "{ name = \"log-canonical\" }".to_owned(),
            given(12),
        ),
    ] {
        let text = scene_of(library, initial, &realization, &dynamics, 0.1);
        coefficients(name, &composed(&text), &mut prepared);
    }
    println!("{table}\n{steps}\n{prepared}");
}
