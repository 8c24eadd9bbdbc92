//! A formula's value and gradient: the compiled code and the exact ring against dual numbers.

use leafwise::expression::algebra::Ring;
use leafwise::expression::bounded::{Bounded, BoundedNumbers};
use leafwise::expression::graph::lift;
use leafwise::expression::syntax::{Formula, Scope};
use leafwise::expression::{Arithmetic, Expression, Graph, Kernel, Rational, Term};

use crate::Reached;
use crate::dual::Dual;
use crate::source::Source;
use crate::tree::{NAMES, Tree};

const DIMENSION: usize = 3;

/// Bounds are of first order: values within so many of them agree.
const WITHIN: f64 = 4.0;

/// A bound below this part of the value makes a comparison worth counting.
const SHARP: f64 = 1e-6;

/// Products of terms that the ring may form.
const PRODUCTS: u64 = 20_000;

/// One formula at one point.
///
/// # Errors
/// What differs, with the formula and the point.
pub fn check(bytes: &[u8]) -> Result<Reached, String> {
    let mut source = Source::new(bytes);
    let point: Vec<f64> = (0..DIMENSION).map(|_| source.decimal(-3.0, 3.0)).collect();
    let depth = 2 + source.below(4);
    compare(&Tree::drawn(&mut source, depth, DIMENSION), &point)
}

/// The same for a given formula.
///
/// # Errors
/// What differs.
pub fn compare(tree: &Tree, x: &[f64]) -> Result<Reached, String> {
    let text = tree.to_string();
    let scope = Scope::new().with_variables(&NAMES[..DIMENSION]);
    let resolved = Formula::parse(&text).and_then(|formula| formula.resolve(&scope, None));
    // Quotients of numbers are carried out, and those by zero refused, at their place.
    let Ok(Some(expression)) = resolved else {
        return Ok(Reached::Refusal);
    };
    let expected = tree.dual(x);
    let mut reached = Reached::Refusal;
    for (way, form) in [("code", coded as Form), ("the ring", ringed as Form)] {
        let Some((graph, outputs)) = form(&expression) else {
            continue;
        };
        let found = evaluated(&graph, &outputs, x);
        if expected.is_rough {
            continue;
        }
        let mut numbers = BoundedNumbers {
            parameters: Vec::new(),
        };
        let Ok(bounds) = numbers.values(&graph, &outputs, x) else {
            continue;
        };
        if agree(&expected, &found, &bounds)
            .map_err(|what| format!("{way} of {text} at {x:?}: {what}"))?
        {
            reached = Reached::Comparison;
        }
    }
    Ok(reached)
}

/// Whether a sharp comparison was made.
fn agree(expected: &Dual, found: &[f64], bounds: &[Bounded]) -> Result<bool, String> {
    let mut is_sharp = false;
    for (part, ((value, error), (found, bound))) in expected
        .parts
        .iter()
        .zip(found.iter().zip(bounds))
        .enumerate()
    {
        let within = WITHIN * (error + bound.error);
        if !within.is_finite() {
            continue;
        }
        if (value - found).abs() <= within {
            is_sharp |= within <= SHARP * value.abs();
            continue;
        }
        let what = match part {
            0 => "the value".to_owned(),
            _ => format!("the derivative along {}", NAMES[part - 1]),
        };
        return Err(format!(
            "{what} is {found:?}, by dual numbers {value:?}, within {within:.1e}"
        ));
    }
    Ok(is_sharp)
}

type Form = fn(&Expression) -> Option<(Graph, Vec<Term>)>;

/// f and ∇f as code of the formula.
fn coded(expression: &Expression) -> Option<(Graph, Vec<Term>)> {
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..DIMENSION).map(|at| graph.input(at)).collect();
    let value = expression
        .evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))
        .ok()?;
    let mut outputs = vec![value.clone()];
    outputs.extend(graph.gradient(&value, DIMENSION).ok()?);
    Some((graph, outputs))
}

/// f and ∇f from the exact ring, where it holds them.
fn ringed(expression: &Expression) -> Option<(Graph, Vec<Term>)> {
    let mut ring = Ring::limited(DIMENSION, PRODUCTS);
    let value = expression
        .evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))
        .ok()?;
    let mut made = vec![value.clone()];
    made.extend(ring.gradient(&value).ok()?);
    if ring.refusal().is_some() {
        return None;
    }
    let mut graph = Graph::new();
    let one = graph.constant(&Rational::one());
    let x: Vec<Term> = (0..DIMENSION).map(|at| graph.input(at)).collect();
    let outputs: Vec<_> = made.into_iter().map(|f| vec![(one.clone(), f)]).collect();
    let outputs = lift(&mut graph, &ring, &outputs, &x).ok()?;
    Some((graph, outputs))
}

fn evaluated(graph: &Graph, outputs: &[Term], x: &[f64]) -> Vec<f64> {
    let kernel = Kernel::compile(graph, outputs, 0, x.len());
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
    let mut values = vec![0.0; outputs.len()];
    kernel.evaluate(&mut workspace, x, &mut values);
    values
}
