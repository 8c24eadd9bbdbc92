//! Straight-line code by the interpreter, by machine code and in any number of lanes: the same bits.

use leafwise::expression::syntax::{Formula, Scope};
use leafwise::expression::{Execution, Function, Graph, Kernel, Term};

use crate::Reached;
use crate::source::Source;
use crate::tree::{NAMES, Tree};

const DIMENSION: usize = 3;

/// Functions that share what they compute where their arguments agree.
const PAIRS: [[Function; 2]; 4] = [
    [Function::Sin, Function::Cos],
    [Function::Exp, Function::Exp],
    [Function::Sinh, Function::Cosh],
    [Function::Tan, Function::Cos],
];

/// A list of formulas with their gradients at one state a lane.
///
/// # Errors
/// The formulas, the states and the output whose bits differ.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let mut source = Source::new(bytes);
    let lanes = 1 + source.below(32);
    let states: Vec<f64> = (0..DIMENSION * lanes).map(|_| source.double()).collect();
    let mut trees = Vec::new();
    for _ in 0..1 + source.below(4) {
        let depth = 1 + source.below(4);
        let tree = Tree::drawn(&mut source, depth, DIMENSION);
        if source.chance(96) {
            let [first, second] = source.pick(&PAIRS);
            let other = match first == second {
                true => Tree::Negate(tree.clone().into()),
                false => tree.clone(),
            };
            trees.push(tree.clone().under(first));
            trees.push(other.under(second));
        }
        trees.push(tree);
    }
    let Some(kernel) = compiled(&trees) else {
        return Ok(Reached::Refusal);
    };
    let interpreted = evaluated(&kernel, Execution::Interpreted, lanes, &states);
    let failure = |how: &str| {
        let formulas: Vec<String> = trees.iter().map(Tree::to_string).collect();
        format!("{how}: other bits for {formulas:?} in {lanes} lanes at {states:?}")
    };
    if evaluated(&kernel, Execution::Compiled, lanes, &states) != interpreted {
        return Err(failure("machine code"));
    }
    for lane in 0..lanes {
        let own: Vec<f64> = (0..DIMENSION).map(|j| states[j * lanes + lane]).collect();
        let alone = evaluated(&kernel, Execution::Interpreted, 1, &own);
        let beside = (0..kernel.outputs()).map(|at| interpreted[at * lanes + lane]);
        if !beside.eq(alone) {
            return Err(failure(&format!("lane {lane} alone")));
        }
    }
    Ok(Reached::Comparison)
}

/// Every formula and its gradient, where they have code.
fn compiled(trees: &[Tree]) -> Option<Kernel> {
    let scope = Scope::new().with_variables(&NAMES[..DIMENSION]);
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..DIMENSION).map(|at| graph.input(at)).collect();
    let mut outputs = Vec::new();
    for tree in trees {
        let formula = Formula::parse(&tree.to_string()).ok()?;
        let Ok(Some(expression)) = formula.resolve(&scope, None) else {
            continue;
        };
        // A formula without any value, such as 1/0, is none of a kernel.
        let Ok(value) = expression.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone())) else {
            continue;
        };
        outputs.extend(graph.gradient(&value, DIMENSION).into_iter().flatten());
        outputs.push(value);
    }
    let has_any = !outputs.is_empty();
    has_any.then(|| Kernel::compile(&graph, &outputs, 0, DIMENSION))
}

fn evaluated(kernel: &Kernel, how: Execution, lanes: usize, states: &[f64]) -> Vec<u64> {
    let mut workspace = kernel.workspace_for(lanes, how);
    // Where the platform has a compiler, machine code is what is compared.
    let is_asked = how == Execution::Compiled && how.describe() == "machine code";
    assert_eq!(workspace.is_compiled(), is_asked, "how a kernel runs");
    let ones = vec![1.0; lanes];
    kernel.prepare(&mut workspace, &[], &ones, &ones);
    let mut values = vec![0.0; kernel.outputs() * lanes];
    kernel.evaluate(&mut workspace, states, &mut values);
    // Which NaN an operation returns is not part of a result.
    let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
    values.into_iter().map(bits).collect()
}
