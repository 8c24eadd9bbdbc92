//! Choices by every way of evaluation, whatever stands in the branch that is not taken.

use std::cell::Cell;

use proptest::prelude::*;

use super::*;
use crate::arithmetic::AlgebraError;
use crate::expression::Expression;
use crate::graph::{Graph, Term};
use crate::kernel::{Execution, Kernel};

const NAMES: [&str; 4] = ["x", "y", "z", "w"];

/// Choices whose conditions and branches are inputs, so that nothing is rounded on the way.
const FORMULAS: [&str; 20] = [
    "if(x > y, z, w)",
    "if(x >= y, z, w)",
    "if(x < 0, z, w)",
    "if(x <= 0, z, w)",
    "exp(if(x > 0, z, w))",
    "2*if(x > 0, -z, w)",
    "if(x > 0, if(y > 0, z, w), z)",
    "if(x > 0 and y > 0, z, w)",
    "if(x > 0 or y > 0, z, w)",
    "min(x, y)",
    "max(x, -y)",
    "abs(x)*heaviside(y)",
    "sign(x) + 3*sign(-y)",
    "floor(if(x > 0, z, 0))",
    "if(x > 0, 1/z, 0)",
    "if(x > 0, sqrt(z), ln(w))",
    "atan2(x, y)",
    "atan2(if(x > 0, z, w), -y)",
    "exp(if(x > -10, sqrt(x - 5), 0))",
    "tanh(min(max(x, y), z))",
];

fn number() -> impl Strategy<Value = f64> {
    let special = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]
        .into_iter()
        .chain([f64::MIN_POSITIVE, f64::from_bits(1), f64::MAX, -1.0, 1.0]);
    prop_oneof![
        1 => -3.0..3.0,
        1 => proptest::sample::select(special.collect::<Vec<f64>>()),
    ]
}

fn kernel_of(formula: &Expression) -> Result<Kernel, AlgebraError> {
    let mut graph = Graph::new();
    let code: Term =
        formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)))?;
    Ok(Kernel::compile(&graph, &[code], 0, NAMES.len()))
}

/// 0 and −0 are one, and all that are no numbers.
fn same(a: f64, b: f64) -> bool {
    a == b || a.is_nan() && b.is_nan()
}

/// A branch that is not taken has no say, whether it is a number or none, and one that is taken is handed on as it is: by the
/// interpreter, by lanes, by machine code and by the formula alike.
#[test]
fn every_evaluation_takes_the_same_branch() {
    let scope = Scope::new().with_variables(&NAMES);
    let formulas = FORMULAS.map(|text| {
        let formula = parse(text).resolve(&scope, None).expect(text).expect(text);
        let kernel = kernel_of(&formula).expect(text);
        (text, formula, kernel)
    });
    let without_a_number = Cell::new(0);
    proptest!(|(numbers in prop::collection::vec(number(), NAMES.len() * 16))| {
        for (text, formula, kernel) in &formulas {
            for lanes in [1, 2, 4, 16] {
                let inputs = &numbers[..NAMES.len() * lanes];
                for execution in [Execution::Interpreted, Execution::Compiled] {
                    let mut workspace = kernel.workspace_for(lanes, execution);
                    let ones = vec![1.0; lanes];
                    kernel.prepare(&mut workspace, &[], &ones, &ones);
                    let mut found = vec![0.0; lanes];
                    kernel.evaluate(&mut workspace, inputs, &mut found);
                    for (lane, found) in found.iter().enumerate() {
                        let x: Vec<f64> = (0..NAMES.len()).map(|i| inputs[i * lanes + lane]).collect();
                        let expected = formula.evaluate(&x, &[]);
                        without_a_number.update(|all| all + usize::from(expected.is_nan()));
                        prop_assert!(
                            same(*found, expected),
                            "{text} at {x:?}: {found}, not {expected}, {execution:?}, {lanes} lanes"
                        );
                    }
                }
            }
        }
    });
    assert!(without_a_number.get() > 1000, "{without_a_number:?}");
}
