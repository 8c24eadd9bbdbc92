//! What lanes save: steppers over formulas, interpreted kernels and elementary functions, a lane each, against one
//! lane and against `libm`, in one run.

#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use leafwise::core::{Registry, Walk};
use leafwise::expression::{
    Arithmetic, Execution, Function, Graph, Kernel, StepSize, Term, elementary,
};
use leafwise::scene::{SceneDocument, compose};
use leafwise_benches::{PERIODIC_LOTKA_VOLTERRA, RIGID_BODY, scene};

/// The shortest of a few runs, in nanoseconds a call.
fn nanoseconds(calls: usize, mut call: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..9 {
        let started = Instant::now();
        for _ in 0..calls {
            call();
        }
        best = best.min(started.elapsed().as_secs_f64() * 1e9 / calls as f64);
    }
    best
}

const LANES: [usize; 9] = [1, 2, 4, 8, 12, 16, 32, 64, 128];

/// y ↦ dŜ(y) of order 8: products and sums.
fn differential() -> Kernel {
    let text = scene(RIGID_BODY.0, RIGID_BODY.1, 6, 8, 0.1);
    let document =
        SceneDocument::parse("bench.toml", &text, &Registry::with_builtin()).expect("a scene");
    let run = compose(&document, &Registry::with_builtin()).expect("a method");
    let method = run.method.written().expect("a method written out");
    let mut graph = Graph::new();
    let y: Vec<Term> = (0..3).map(|i| graph.input(i)).collect();
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let code = method.bisection().code().expect("code");
    let z = code(&mut graph, &epsilon, &h, &y).expect("code");
    Kernel::compile(&graph, &z[3..], run.system.parameters().len(), 3)
}

/// The Hamiltonian field of a system with logarithms: divisions.
fn field() -> (Vec<f64>, Kernel) {
    let text = scene(
        PERIODIC_LOTKA_VOLTERRA.0,
        PERIODIC_LOTKA_VOLTERRA.1,
        2,
        2,
        0.1,
    );
    let document =
        SceneDocument::parse("bench.toml", &text, &Registry::with_builtin()).expect("a scene");
    let run = compose(&document, &Registry::with_builtin()).expect("a method");
    let formulas = run.system.formulas("a bench").expect("formulas");
    let kernel = formulas.vector_field_kernel().expect("a field");
    (run.system.parameter_values(), kernel)
}

/// A rotation and an exponential: functions.
fn flow() -> Kernel {
    let mut graph = Graph::new();
    let [x, y, z] = [0, 1, 2].map(|i| graph.input(i));
    let h = graph.step_size(StepSize::H);
    let angle = graph.multiply(&h, &z);
    let [exp, sin, cos] = [Function::Exp, Function::Sin, Function::Cos]
        .map(|function| graph.apply(function, &angle).expect("code"));
    let turned = [(&x, &cos), (&y, &sin), (&z, &exp)].map(|(a, b)| graph.multiply(a, b));
    Kernel::compile(&graph, &turned, 0, 3)
}

fn kernel_table(name: &str, kernel: &Kernel, parameters: &[f64], initial: &[f64]) {
    println!("{name}: {}", kernel.step_operations());
    let mut alone = 0.0;
    for lanes in LANES {
        let each = |execution: Execution| {
            let mut workspace = kernel.workspace_for(lanes, execution);
            let spread = |values: &[f64]| -> Vec<f64> {
                let lanes = |value: &f64| std::iter::repeat_n(*value, lanes);
                values.iter().flat_map(lanes).collect()
            };
            let sizes = (vec![0.1; lanes], vec![1.0; lanes]);
            kernel.prepare(&mut workspace, &spread(parameters), &sizes.0, &sizes.1);
            let inputs = spread(initial);
            let mut outputs = vec![0.0; kernel.outputs() * lanes];
            nanoseconds(200_000 / (lanes + 8), || {
                kernel.evaluate(&mut workspace, black_box(&inputs), &mut outputs);
                black_box(&mut outputs);
            }) / lanes as f64
        };
        let (interpreted, compiled) = (each(Execution::Interpreted), each(Execution::Compiled));
        if lanes == 1 {
            alone = interpreted;
        }
        println!(
            "  {lanes:4} lanes: interpreted {interpreted:7.2} ns a lane ({:5.2} times one lane's \
             speed), compiled {compiled:7.2} ns ({:5.2})",
            alone / interpreted,
            alone / compiled,
        );
    }
}

fn function_table() {
    type Lanes = fn(&mut [f64]);
    type Row = (&'static str, Lanes, fn(f64) -> f64, f64, f64);
    let both: Lanes = |values| {
        let mut cosines = [0.0; 1024];
        elementary::sin_cos_lanes(values, &mut cosines[..values.len()]);
        black_box(&mut cosines);
    };
    let functions: [Row; 9] = [
        ("exp", elementary::exp_lanes, libm::exp, -2.0, 2.0),
        ("expm1", elementary::exp_m1_lanes, libm::expm1, -2.0, 2.0),
        ("ln", elementary::ln_lanes, libm::log, 0.1, 5.0),
        ("sqrt", elementary::sqrt_lanes, libm::sqrt, 0.1, 5.0),
        ("sin", elementary::sin_lanes, libm::sin, -10.0, 10.0),
        ("cos", elementary::cos_lanes, libm::cos, -10.0, 10.0),
        ("sincos", both, |x| libm::sincos(x).0, -10.0, 10.0),
        ("tan", elementary::tan_lanes, libm::tan, -10.0, 10.0),
        ("atan", elementary::atan_lanes, libm::atan, -10.0, 10.0),
    ];
    println!("elementary functions, ns a lane (times libm's speed)");
    for (name, lanes, scalar, low, high) in functions {
        print!("  {name:6}");
        let arguments = |n: usize| -> Vec<f64> {
            let place = |at: usize| (at * 617 % 1021) as f64 / 1021.0;
            (0..n).map(|at| low + (high - low) * place(at)).collect()
        };
        let all = arguments(1024);
        let mut values = all.clone();
        let alone = nanoseconds(50, || {
            for (value, x) in values.iter_mut().zip(black_box(&all)) {
                *value = scalar(*x);
            }
            black_box(&mut values);
        }) / 1024.0;
        print!(" libm {alone:5.2}");
        for n in [4, 8, 16, 32, 1024] {
            let arguments = arguments(n);
            let mut values = arguments.clone();
            let each = nanoseconds(50_000 / n, || {
                values.copy_from_slice(black_box(&arguments));
                lanes(&mut values);
                black_box(&mut values);
            }) / n as f64;
            print!("  {n}: {each:5.2} ({:4.1})", alone / each);
        }
        println!();
    }
}

/// A step of baselines over formulas on trajectories side by side: all with the same parameters, and each with its own.
fn stepper_table() {
    println!("steppers over formulas, ns a step and lane (times one lane's speed)");
    for (name, system) in [
        ("rigid body", RIGID_BODY),
        ("periodic Lotka-Volterra", PERIODIC_LOTKA_VOLTERRA),
    ] {
        for stepper in ["rk4", "gauss", "implicit-midpoint", "dop853", "taylor"] {
            let (library, initial) = system;
            let text = format!(
                "[system]\nlibrary = \"{library}\"\n[method]\nstepper = \"{stepper}\"\ntime-step = 0.05\n\
                 [run]\ninitial = {initial}\nsteps = 1\n"
            );
            let document = SceneDocument::parse("bench.toml", &text, &Registry::with_builtin());
            let run = compose(&document.expect("a scene"), &Registry::with_builtin());
            let run = run.expect("a stepper");
            let parameters = run.system.parameter_values();
            for (which, apart) in [("the same parameters", 0.0), ("their own", 1e-3)] {
                let mut alone = 0.0;
                print!("  {name}, {stepper}, {which}:");
                for lanes in [1, 8, 16, 64] {
                    let own =
                        |value: f64| (0..lanes).map(move |w| value * (1.0 + apart * w as f64));
                    let all: Vec<f64> = parameters.iter().flat_map(|value| own(*value)).collect();
                    let each = |x: &f64| std::iter::repeat_n(*x, lanes);
                    let initial: Vec<f64> = run.plan.initial.iter().flat_map(each).collect();
                    let map = run.method.map();
                    let mut going = Walk::side_by_side(map, lanes, (&all, &initial), 1.0, 0.05);
                    let steps = 20_000 / lanes;
                    let time = nanoseconds(steps, || {
                        going.step().expect("a step");
                    }) / lanes as f64;
                    if lanes == 1 {
                        alone = time;
                    }
                    print!("  {lanes}: {time:6.1} ({:4.1})", alone / time);
                }
                println!();
            }
        }
    }
}

fn main() {
    stepper_table();
    function_table();
    kernel_table(
        "dS of order 8, rigid body",
        &differential(),
        &[1.0, 0.75, 1.25],
        &[1.0, 3.0, 3.0],
    );
    let (parameters, kernel) = field();
    kernel_table(
        "field of Lotka-Volterra",
        &kernel,
        &parameters,
        &[1.0, 1.9, 0.5],
    );
    kernel_table("rotation and exponential", &flow(), &[], &[1.0, 1.9, 0.5]);
}
