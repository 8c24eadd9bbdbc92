//! Code of formulas in pieces: how long it is, and where it has a value.

use crate::algebra::Ring;
use crate::arithmetic::Arithmetic;
use crate::differential::DifferentialAlgebra;
use crate::expression::Expression;
use crate::graph::{Graph, Term, lift};
use crate::kernel::Kernel;
use crate::rational::Rational;
use crate::series::jet;
use crate::syntax::{Formula, Scope};

fn resolved(text: &str) -> Expression {
    let scope = Scope::new()
        .with_variables(&["x", "y"])
        .with_parameters(&["a"]);
    let formula = Formula::parse(text).expect(text);
    formula.resolve(&scope, None).expect(text).expect(text)
}

fn code(graph: &mut Graph, formula: &Expression) -> Term {
    let code = formula.evaluate_in(graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
    code.expect("code")
}

fn values(graph: &Graph, terms: &[Term], x: [f64; 2], a: f64) -> Vec<f64> {
    let kernel = Kernel::compile(graph, terms, 1, 2);
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[a], &[1.0], &[1.0]);
    let mut values = vec![0.0; terms.len()];
    kernel.evaluate(&mut workspace, &x, &mut values);
    values
}

/// Formulas in which each level stands in its condition and in both of its branches.
const NESTED: [(&str, &str); 5] = [
    ("x", "mod({}*1.5, 1 + y^2)"),
    ("x", "if({} > 0, {}^2, sin({}) - y)"),
    ("x", "max({}*y, 1/2 - {})"),
    ("x", "min(x*{}, 2*{}, {} + y)"),
    ("x", "abs({} - y)*if({} < 1/2 or {} > 2 and y < 3, {}, 1)"),
];

/// Nodes of the code with its gradient, of so many levels.
fn nodes(start: &str, level: &str, depth: usize) -> usize {
    // Written out the text has 4^depth parts: each level is shared.
    let inner = resolved(start);
    let scope = |formula: Expression| {
        Scope::new()
            .with_variables(&["x", "y"])
            .with_definition("u", formula)
    };
    let level = level.replace("{}", "u");
    let formula = (0..depth).fold(inner, |formula, _| {
        let parsed = Formula::parse(&level).expect("a level");
        let next = parsed.resolve(&scope(formula.shared()), None);
        next.expect("known names").expect("no boundary")
    });
    let mut graph = Graph::new();
    let term = code(&mut graph, &formula);
    let gradient = graph.gradient(&term, 2).expect("derivatives");
    let forward = graph.derivative(&term, 0).expect("derivatives");
    let [a, b] = [&gradient[0], &forward]
        .map(|slope| values(&graph, std::slice::from_ref(slope), [0.3, 0.7], 1.0)[0]);
    assert!(
        (a - b).abs() <= 1e-9 * a.abs().max(1.0),
        "{level}: {a} and {b}"
    );
    graph.len()
}

/// Slopes of what stands behind d seams are products of up to d factors: no more than quadratically many nodes. Exponential
/// growth, by 2 a level or more, would make 2¹⁰ times as many of ten levels more.
#[test]
fn nested_choices_are_polynomial() {
    for (start, level) in NESTED {
        let [short, long] = [6, 24].map(|depth| nodes(start, level, depth));
        assert!(long <= 32 * short, "{level}: {short} and {long} nodes");
    }
}

/// A list of alternatives shares what comes after each of its parts.
#[test]
fn long_conditions_are_linear() {
    let size = |parts: usize| {
        let parts = (0..parts).map(|k| format!("{k} < x < {k} + 1/2 or y == {k}"));
        let parts: Vec<String> = parts.collect();
        let formula = resolved(&format!("if({}, x^2, y)", parts.join(" or ")));
        let mut graph = Graph::new();
        code(&mut graph, &formula);
        graph.len()
    };
    let (short, long) = (size(4), size(40));
    assert!(long <= 12 * short, "{short} and {long} nodes");
}

/// Constants behind a seam are left there: 1/a of a = 0, ln of a negative number.
#[test]
fn constants_stay_behind_their_seam() {
    for (text, x, a, expected) in [
        ("if(x > 0, x/a, y)", -1.0, 0.0, 7.0),
        ("if(x > 0, x*ln(a), y)", -1.0, -2.0, 7.0),
        ("if(x <= 0, y, a^(-3))", -1.0, 0.0, 7.0),
        ("if(x > 0, sqrt(a)*x, y*x/x)", -1.0, -2.0, 7.0),
        ("if(a > 0, x/a, y)", -1.0, 0.0, 7.0),
        ("if(x > 0, x/a, y)", 3.0, 2.0, 1.5),
        (
            "if(x > 0, if(y > 0, x/a, 1), if(y > 0, y, x/a))",
            -1.0,
            0.0,
            7.0,
        ),
        ("if(x < 0, y, 1/heaviside(x))", -1.0, 1.0, 7.0),
    ] {
        let formula = resolved(text);
        let mut ring = Ring::new(2);
        let element =
            formula.evaluate_in(&mut ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)));
        let element = element.expect(text);
        let back = ring.formula(&element).evaluate(&[x, 7.0], &[a]);
        assert_eq!(back, expected, "{text} by the ring's formula");
        let mut graph = Graph::new();
        let inputs = [0, 1].map(|at| graph.input(at));
        let one = graph.constant(&Rational::one());
        let slope = ring.partial(&element, 1).expect("a derivative");
        let outputs = [vec![(one.clone(), element)], vec![(one, slope)]];
        let lifted = lift(&mut graph, &ring, &outputs, &inputs).expect("code");
        let found = values(&graph, &lifted, [x, 7.0], a);
        assert_eq!(found[0], expected, "{text} by the ring's code");
        assert!(found[1].is_finite(), "{text}: a slope of {}", found[1]);
    }
}

/// 1/g of what is 0 on a side is no number there, and cancels no g.
#[test]
fn what_is_zero_on_a_side_does_not_cancel() {
    for text in [
        "heaviside(x)/heaviside(x)",
        "if(x > 0, y, 0)/if(x > 0, y, 0)",
    ] {
        let formula = resolved(text);
        let mut ring = Ring::new(2);
        let element =
            formula.evaluate_in(&mut ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)));
        let back = ring.formula(&element.expect(text));
        assert!(back.evaluate(&[-1.0, 2.0], &[0.0]).is_nan(), "{text}");
        assert_eq!(back.evaluate(&[1.0, 2.0], &[0.0]), 1.0, "{text}");
    }
}

/// Along ẋ = −y, ẏ = 1 the angle has the series of its derivative, and its code is a few operations an order.
#[test]
fn angles_have_series() {
    let mut graph = Graph::new();
    let formulas = ["atan2(y, x)", "mod(x + 3*y, 2)"].map(resolved);
    let field: Vec<Term> = formulas.iter().map(|f| code(&mut graph, f)).collect();
    let coefficients = jet(&mut graph, &field, 8).expect("a jet");
    assert!(graph.len() < 1200, "{} nodes", graph.len());
    // x_{k+1} = f_k/(k + 1): f along the truncated solution, at three times, beside its own series.
    let flat: Vec<Term> = coefficients.concat();
    let (x, y) = (0.4, 0.8);
    let found = values(&graph, &flat, [x, y], 1.0);
    let at = |t: f64, component: usize| {
        let own = [x, y][component];
        (1..=8).fold(own, |sum, k| {
            sum + found[2 * (k - 1) + component] * libm::pow(t, k as f64)
        })
    };
    for t in [0.01, 0.02, -0.015] {
        for component in [0, 1] {
            let slope = (1..=8).fold(0.0, |sum, k| {
                sum + k as f64 * found[2 * (k - 1) + component] * libm::pow(t, k as f64 - 1.0)
            });
            let field = formulas[component].evaluate(&[at(t, 0), at(t, 1)], &[1.0]);
            // Nine times the ninth coefficient, below 10³ so far from the origin, at t⁸ < 3·10⁻¹⁴.
            assert!(
                (slope - field).abs() < 3e-10,
                "{component} at {t}: {slope}, {field}"
            );
        }
    }
}
