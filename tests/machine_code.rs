//! Machine code computes the bits of the interpreter: random graphs of every operation, with
//! special values among the inputs; and whole steps of methods.

use std::sync::Mutex;

use leafwise::core::Registry;
use leafwise::expression::table::{Lookup, TableAxis, TableFunction};
use leafwise::expression::{
    AnalyticFunction, Arithmetic, Execution, Function, Graph, Kernel, Rational, Side, Term,
};
use leafwise::run::{Quiet, RunJob, RunOptions, perform};
use leafwise::scene::{SceneDocument, compose};
use proptest::prelude::*;

const INPUTS: usize = 5;

const CUBE: AnalyticFunction = AnalyticFunction::new("cube", |order, s| match order {
    0 => s * s * s,
    1 => 3.0 * s * s,
    2 => 6.0 * s,
    3 => 6.0,
    _ => 0.0,
});

/// One more node of a graph, its operands chosen among the nodes so far.
#[derive(Clone, Debug)]
enum Choice {
    Add(usize, usize),
    Subtract(usize, usize),
    Multiply(usize, usize),
    Divide(usize, usize),
    Scale(i64, i64, usize),
    IntegerPower(i64, usize),
    Power(usize, usize),
    Apply(Function, usize),
    ApplyAnalytic(u32, usize),
    Kept(Side, usize, usize),
    LookUp([u8; 2], usize, usize),
}

/// A table of two variables, one of them periodic.
fn table() -> TableFunction {
    let axis = |name: &str, nodes, is_periodic| TableAxis {
        name: name.to_owned(),
        first: -1.5,
        last: 2.0,
        nodes,
        is_periodic,
    };
    let numbers: Vec<f64> = (0..63).map(|at| f64::from(at * 29 % 17) - 8.0).collect();
    let axes = vec![axis("x", 7, false), axis("y", 9, true)];
    TableFunction::new("grid", axes, 4, &numbers).expect("a table")
}

fn choice() -> impl Strategy<Value = Choice> {
    let at = || any::<usize>();
    prop_oneof![
        4 => (at(), at()).prop_map(|(a, b)| Choice::Add(a, b)),
        4 => (at(), at()).prop_map(|(a, b)| Choice::Subtract(a, b)),
        4 => (at(), at()).prop_map(|(a, b)| Choice::Multiply(a, b)),
        2 => (at(), at()).prop_map(|(a, b)| Choice::Divide(a, b)),
        2 => (-9_i64..9, 1_i64..9, at()).prop_map(|(n, d, a)| Choice::Scale(n, d, a)),
        1 => (-4_i64..6, at()).prop_map(|(n, a)| Choice::IntegerPower(n, a)),
        1 => (at(), at()).prop_map(|(a, b)| Choice::Power(a, b)),
        2 => (0..Function::ALL.len(), at()).prop_map(|(f, a)| Choice::Apply(Function::ALL[f], a)),
        1 => (0_u32..5, at()).prop_map(|(k, a)| Choice::ApplyAnalytic(k, a)),
        1 => (0_u8..5, 0_u8..5, at(), at()).prop_map(|(i, j, a, b)| Choice::LookUp([i, j], a, b)),
        2 => (any::<bool>(), at(), at()).prop_map(|(is_above, c, v)| {
            Choice::Kept(if is_above { Side::Above } else { Side::Below }, c, v)
        }),
    ]
}

fn number() -> impl Strategy<Value = f64> {
    let special = [
        0.0,
        -0.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MIN_POSITIVE,
        -f64::MIN_POSITIVE / 8.0,
        f64::from_bits(1),
        f64::MAX,
        1.0,
        -1.0,
    ];
    prop_oneof![
        3 => -4.0..4.0,
        1 => any::<f64>(),
        1 => proptest::sample::select(special.to_vec()),
    ]
}

/// The kernel of `choices`, its outputs among all nodes, inputs and repetitions included.
fn kernel(choices: &[Choice], outputs: &[usize]) -> Kernel {
    let mut graph = Graph::new();
    let mut nodes: Vec<Term> = (0..INPUTS).map(|i| graph.input(i)).collect();
    nodes.push(graph.parameter(0));
    nodes.push(graph.constant(&Rational::new(3, 7)));
    for choice in choices {
        let term = |at: &usize| nodes[at % nodes.len()].clone();
        let next = match choice {
            Choice::Add(a, b) => Ok(graph.add(&term(a), &term(b))),
            Choice::Subtract(a, b) => Ok(graph.subtract(&term(a), &term(b))),
            Choice::Multiply(a, b) => Ok(graph.multiply(&term(a), &term(b))),
            Choice::Divide(a, b) => graph.divide(&term(a), &term(b)),
            Choice::Scale(n, d, a) => Ok(graph.scale(&Rational::new(*n, *d), &term(a))),
            Choice::IntegerPower(n, a) => graph.integer_power(&term(a), *n),
            Choice::Power(a, b) => graph.power(&term(a), &term(b)),
            Choice::Apply(function, a) => graph.apply(*function, &term(a)),
            Choice::ApplyAnalytic(order, a) => Ok(graph.apply_analytic(CUBE, *order, &term(a))),
            Choice::Kept(side, c, v) => graph.kept(*side, &term(c), &term(v)),
            Choice::LookUp(orders, a, b) => {
                let lookup = Lookup::of_orders(table(), orders).expect("a derivative");
                graph.look_up(lookup, &[term(a), term(b)])
            }
        };
        // A division by an exact zero has no code.
        nodes.extend(next);
    }
    let outputs: Vec<Term> = outputs
        .iter()
        .map(|at| nodes[at % nodes.len()].clone())
        .chain(nodes.last().cloned())
        .collect();
    Kernel::compile(&graph, &outputs, 1, INPUTS)
}

fn evaluated(kernel: &Kernel, execution: Execution, lanes: usize, inputs: &[f64]) -> Vec<u64> {
    let mut workspace = kernel.workspace_for(lanes, execution);
    assert_eq!(workspace.is_compiled(), execution == Execution::Compiled);
    let parameters: Vec<f64> = (0..lanes).map(|w| 0.3 + w as f64).collect();
    let ones = vec![1.0; lanes];
    kernel.prepare(&mut workspace, &parameters, &ones, &ones);
    let mut outputs = vec![0.0; kernel.outputs() * lanes];
    // Twice: nothing of the first evaluation may be left over.
    for inputs in [&vec![0.5; inputs.len()][..], inputs] {
        kernel.evaluate(&mut workspace, inputs, &mut outputs);
    }
    // The payload of a NaN is not part of a result.
    let bits = |x: &f64| {
        if x.is_nan() {
            f64::NAN.to_bits()
        } else {
            x.to_bits()
        }
    };
    outputs.iter().map(bits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn machine_code_computes_the_bits_of_the_interpreter(
        choices in prop::collection::vec(choice(), 1..150),
        outputs in prop::collection::vec(any::<usize>(), 0..12),
        inputs in prop::collection::vec(number(), INPUTS * 16),
    ) {
        let kernel = kernel(&choices, &outputs);
        for lanes in [1, 2, 3, 8, 16] {
            let inputs = &inputs[..INPUTS * lanes];
            prop_assert_eq!(
                evaluated(&kernel, Execution::Compiled, lanes, inputs),
                evaluated(&kernel, Execution::Interpreted, lanes, inputs)
            );
        }
    }
}

/// The states of 10⁴ steps, folded into one number bit by bit, and the last state.
fn steps(text: &str, execution: Execution) -> (u64, Vec<u64>) {
    execution.set_default_of_process();
    let document =
        SceneDocument::parse("test.toml", text, &Registry::with_builtin()).expect("a scene");
    let run = compose(&document, &Registry::with_builtin()).expect("a method");
    let mut walk = run.walk();
    let mut digest = 0_u64;
    for _ in 0..10_000 {
        walk.step().expect("a step");
        for x in walk.state() {
            digest = digest.rotate_left(5).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ x.to_bits();
        }
    }
    // A step takes some of a solver's kernels and not others.
    let kernels = run.method.map().abilities().kernels;
    let mut kernels = kernels.iter();
    let is_compiled = kernels.any(|(_, kernel)| !kernel.machine_code().is_empty());
    assert_eq!(is_compiled, execution != Execution::Interpreted, "{text}");
    (digest, walk.state().iter().map(|x| x.to_bits()).collect())
}

/// Held by tests that set or rely on the execution of the whole process.
static EXECUTION: Mutex<()> = Mutex::new(());

#[test]
fn whole_steps_have_the_same_bits() {
    let _held = EXECUTION.lock().expect("no other test failed");
    let scene = |library: &str, initial: &str, realization: &str, m: usize, time_step: f64| {
        format!(
            "[system]\nlibrary = \"{library}\"\n[method]\nrealization = {realization}\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = {m} }}\n\
             time-step = {time_step}\n[run]\ninitial = {initial}\nsteps = 1\n"
        )
    };
    let truncated = "{ name = \"karasev-truncated\", order = 6 }";
    let so3 = "{ name = \"so3-exponential\" }";
    let logarithmic = "{ name = \"log-canonical\" }";
    let heavy = "[0.5, -0.4, 1.2, 0.6, 0.0, 0.8]";
    for text in [
        scene("rigid-body", "[1, 3, 3]", truncated, 4, 0.1),
        scene("rigid-body", "[1, 3, 3]", so3, 8, 0.1),
        scene(
            "lotka-volterra-periodic",
            "[1, 1.9, 0.5]",
            truncated,
            4,
            0.05,
        ),
        scene(
            "lotka-volterra-periodic",
            "[1, 1.9, 0.5]",
            logarithmic,
            4,
            0.05,
        ),
        scene("heavy-top", heavy, truncated, 4, 0.05),
        format!(
            "[system]\nlibrary = \"heavy-top\"\n[method]\n\
             stepper = {{ name = \"splitting\", bodies = \"whole\" }}\ntime-step = 0.05\n\
             [run]\ninitial = {heavy}\nsteps = 1\n"
        ),
    ] {
        let interpreted = steps(&text, Execution::Interpreted);
        assert_eq!(steps(&text, Execution::Compiled), interpreted, "{text}");
        assert_eq!(steps(&text, Execution::Adaptive), interpreted, "{text}");
    }
}

#[test]
fn the_manifest_says_what_was_compiled() {
    let _held = EXECUTION.lock().expect("no other test failed");
    let text = "[system]\nlibrary = \"rigid-body\"\n[method]\n\
                realization = { name = \"karasev-truncated\", order = 4 }\n\
                dynamics = { name = \"hamilton-jacobi\", order = 2 }\n\
                time-step = 0.1\n[run]\ninitial = [1, 3, 3]\nsteps = 1000\n";
    let root = tempfile::tempdir().expect("a directory");
    for execution in [Execution::Interpreted, Execution::Adaptive] {
        execution.set_default_of_process();
        let document =
            SceneDocument::parse("top.toml", text, &Registry::with_builtin()).expect("a scene");
        let registry = Registry::with_builtin();
        let composed = compose(&document, &registry).expect("a method");
        let options = RunOptions {
            command: "leafwise run top.toml".to_owned(),
            ..RunOptions::within(root.path().join(format!("{execution:?}")))
        };
        let job = RunJob::new(&document, &composed, &registry, &options).expect("a job");
        perform(&job, &mut Quiet).expect("a run");
        let manifest = options.directory.join("manifest.json");
        let manifest = std::fs::read_to_string(manifest).expect("a manifest");
        let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
        let compiled = manifest["machine_code"].as_array().expect("a list");
        if execution == Execution::Interpreted {
            assert!(compiled.is_empty(), "{compiled:?}");
            continue;
        }
        let method = composed.method.written().expect("a method");
        let operations = method.newton().expect("one kernel").operations().total();
        let newton = compiled
            .iter()
            .find(|entry| entry["kernel"] == "Newton iteration")
            .expect("the iteration was compiled");
        assert_eq!(newton["operations"], operations);
        assert_eq!(newton["lanes"], 1);
    }
}
