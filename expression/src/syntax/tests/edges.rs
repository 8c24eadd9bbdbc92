//! Values at the ends of domains, at poles and at infinities.

use super::*;
use crate::arithmetic::AlgebraError;
use crate::graph::Graph;
use crate::kernel::{Execution, Kernel};

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

/// Functions of x at numbers where C's Annex F (F.10), or else the limit from inside of the domain, says the value. Poles
/// whose sides differ have none, except at ±0, which has a sign.
const OF_ONE: [(&str, f64, f64); 74] = [
    ("ln(x)", 0.0, -INF),
    ("ln(x)", -1.0, NAN),
    ("ln(x)", INF, INF),
    ("log10(x)", 0.0, -INF),
    ("log2(x)", -0.0, -INF),
    ("log2(x)", -1.0, NAN),
    ("sqrt(x)", -1.0, NAN),
    ("sqrt(x)", INF, INF),
    ("exp(x)", -INF, 0.0),
    ("exp(x)", INF, INF),
    ("sin(x)", INF, NAN),
    ("tan(x)", -INF, NAN),
    ("asin(x)", 1.5, NAN),
    ("acos(x)", -1.5, NAN),
    ("atan(x)", INF, std::f64::consts::FRAC_PI_2),
    ("acosh(x)", 0.5, NAN),
    ("atanh(x)", 1.0, INF),
    ("atanh(x)", -1.0, -INF),
    ("atanh(x)", 1.5, NAN),
    ("tanh(x)", -INF, -1.0),
    ("cosh(x)", -INF, INF),
    ("abs(x)", -INF, INF),
    ("sign(x)", -INF, -1.0),
    ("sign(x)", INF, 1.0),
    ("sign(x)", -0.0, 0.0),
    ("sign(x)", NAN, NAN),
    ("heaviside(x)", INF, 1.0),
    ("heaviside(x)", -INF, 0.0),
    ("heaviside(x)", NAN, NAN),
    ("floor(x)", -INF, -INF),
    ("ceil(x)", INF, INF),
    ("min(x, 1)", -INF, -INF),
    ("max(x, 1)", -INF, 1.0),
    ("max(x, 1)", NAN, NAN),
    ("erf(x)", INF, 1.0),
    ("erf(x)", -INF, -1.0),
    ("erfc(x)", INF, 0.0),
    ("erfc(x)", -INF, 2.0),
    ("gamma(x)", 0.0, INF),
    ("gamma(x)", -0.0, -INF),
    ("gamma(x)", -3.0, NAN),
    ("gamma(x)", INF, INF),
    ("gamma(x)", -INF, NAN),
    ("gamma(x)", 200.0, INF),
    ("lgamma(x)", 0.0, INF),
    ("lgamma(x)", -3.0, INF),
    ("lgamma(x)", -INF, INF),
    ("lgamma(x, 1)", 0.0, -INF),
    ("lgamma(x, 1)", -0.0, INF),
    ("lgamma(x, 1)", -3.0, NAN),
    ("lgamma(x, 2)", 0.0, INF),
    ("lgamma(x, 2)", -3.0, INF),
    ("lgamma(x, 3)", -3.0, NAN),
    ("lgamma(x, 1)", INF, INF),
    ("lgamma(x, 2)", INF, 0.0),
    ("lgamma(x, 1)", -INF, NAN),
    ("lgamma(x, 255)", 0.5, -INF),
    ("j0(x)", INF, 0.0),
    ("j1(x)", -INF, 0.0),
    ("j0(x, 5)", INF, 0.0),
    ("ellipk(x)", 1.0, INF),
    ("ellipk(x)", 1.5, NAN),
    ("ellipk(x)", -INF, 0.0),
    ("ellipk(x, 1)", 1.0, INF),
    ("ellipk(x, 2)", 1.5, NAN),
    ("ellipk(x, 1)", -INF, 0.0),
    ("ellipk(x, 255)", 0.9, INF),
    ("ellipe(x)", 1.0, 1.0),
    ("ellipe(x)", 1.5, NAN),
    ("ellipe(x)", -INF, INF),
    ("ellipe(x, 1)", 1.0, -INF),
    ("ellipe(x, 3)", 1.0, -INF),
    ("ellipe(x, 1)", -INF, 0.0),
    ("ellipe(x, 255)", 0.9, -INF),
];

/// Functions of y and x: `atan2` as in F.10.1.4, `mod` as Python's and NumPy's.
const OF_TWO: [(&str, f64, f64, f64); 34] = [
    ("atan2(y, x)", 0.0, 0.0, 0.0),
    ("atan2(y, x)", -0.0, 0.0, -0.0),
    ("atan2(y, x)", 0.0, -0.0, std::f64::consts::PI),
    ("atan2(y, x)", -0.0, -0.0, -std::f64::consts::PI),
    ("atan2(y, x)", 0.0, -2.0, std::f64::consts::PI),
    ("atan2(y, x)", -0.0, -2.0, -std::f64::consts::PI),
    ("atan2(y, x)", -0.0, 2.0, -0.0),
    ("atan2(y, x)", -1.0, 0.0, -std::f64::consts::FRAC_PI_2),
    ("atan2(y, x)", 1.0, -0.0, std::f64::consts::FRAC_PI_2),
    ("atan2(y, x)", 2.0, -INF, std::f64::consts::PI),
    ("atan2(y, x)", -2.0, -INF, -std::f64::consts::PI),
    ("atan2(y, x)", 2.0, INF, 0.0),
    ("atan2(y, x)", INF, 5.0, std::f64::consts::FRAC_PI_2),
    ("atan2(y, x)", -INF, 5.0, -std::f64::consts::FRAC_PI_2),
    ("atan2(y, x)", INF, INF, std::f64::consts::FRAC_PI_4),
    ("atan2(y, x)", INF, -INF, 3.0 * std::f64::consts::FRAC_PI_4),
    ("atan2(y, x)", -INF, INF, -std::f64::consts::FRAC_PI_4),
    ("atan2(y, x)", NAN, 1.0, NAN),
    ("atan2(y, x)", 1.0, NAN, NAN),
    ("atan2(y, x)", 1e-300, 1e300, 0.0),
    ("atan2(y, x)", 1e200, 1e200, std::f64::consts::FRAC_PI_4),
    ("atan2(y, y)", 0.0, 1.0, 0.0),
    ("mod(y, x)", 5.0, 0.0, NAN),
    ("mod(y, x)", INF, 3.0, NAN),
    ("mod(y, x)", 5.0, INF, 5.0),
    ("mod(y, x)", -5.0, INF, INF),
    ("mod(y, x)", 5.0, -INF, -INF),
    ("mod(y, x)", -1e-20, 1.0, 0.0),
    ("mod(y, x)", 1e-300, 1e-200, 1e-300),
    ("mod(y, x)", 3e-200, 2e-200, 1e-200),
    ("mod(y, x)", -1e200, 3e200, 2e200),
    ("mod(y, x)", 1e300, 1e-300, 4.891_554_850_853_602e-301),
    ("mod(y, x)", -7.0, -2.0, -1.0),
    ("mod(y, x)", NAN, 1.0, NAN),
];

/// The value of the formula, of its code by both executions, and of the text at parameters.
fn everywhere(text: &str, numbers: [f64; 2]) -> Vec<(&'static str, f64)> {
    let scope = Scope::new().with_variables(&["x", "y"]);
    let formula = parse(text).resolve(&scope, None).expect(text).expect(text);
    let mut values = vec![("formula", formula.evaluate(&numbers, &[]))];
    let mut graph = Graph::new();
    let code: Result<_, AlgebraError> =
        formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
    let kernel = Kernel::compile(&graph, &[code.expect(text)], 0, 2);
    for (what, execution) in [
        ("interpreter", Execution::Interpreted),
        ("machine code", Execution::Compiled),
    ] {
        for lanes in [1, 8] {
            let mut workspace = kernel.workspace_for(lanes, execution);
            let ones = vec![1.0; lanes];
            kernel.prepare(&mut workspace, &[], &ones, &ones);
            let mut found = vec![0.0; lanes];
            let inputs = numbers.map(|number| vec![number; lanes]).concat();
            kernel.evaluate(&mut workspace, &inputs, &mut found);
            values.push((what, found[lanes - 1]));
        }
    }
    let parameters = Scope::new().with_parameters(&["x", "y"]);
    let value = parse(text).value(&parameters, &numbers, None);
    values.push(("value", value.expect(text)));
    values
}

fn check(text: &str, numbers: [f64; 2], expected: f64) {
    for (what, found) in everywhere(text, numbers) {
        let is_same = found == expected || found.is_nan() && expected.is_nan();
        let is_signed = expected == 0.0 && text.starts_with("atan2");
        let is_of_sign = !is_signed || found.is_sign_negative() == expected.is_sign_negative();
        assert!(
            is_same && is_of_sign,
            "{text} at {numbers:?}: {found} by {what}, not {expected}"
        );
    }
}

#[test]
fn values_at_the_ends_of_domains_are_those_of_c() {
    for (text, x, expected) in OF_ONE {
        check(text, [x, 0.0], expected);
    }
    for (text, y, x, expected) in OF_TWO {
        check(text, [x, y], expected);
    }
}

/// A remainder of numbers is exact, as that of rational numbers is.
#[test]
fn remainders_of_numbers_are_exact() {
    for (text, expected) in [
        ("mod(7.5, 2)", 1.5),
        ("mod(-0.3, 0.1)", 0.0),
        ("mod(-1/3, 1)", 2.0 / 3.0),
        ("mod(10^30, 7)", 1.0),
        ("floor(-10^30/7)*7 + 10^30", -6.0),
    ] {
        let mut graph = Graph::new();
        let formula = resolve(text);
        let code =
            formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
        let code = code.expect(text);
        assert_eq!(code.node, Graph::ONE, "{text} is a number");
        assert_eq!(code.scale.to_f64(), expected, "{text}");
    }
    let mut graph = Graph::new();
    let zero = resolve("mod(3, 0)");
    let code = zero.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
    assert!(matches!(code, Err(AlgebraError::OutsideDomain { .. })));
}
