//! The functions of formulas against values of `data/functions.json`, which mpmath computed at 60 digits, and their
//! derivatives against differences.

use leafwise::expression::operators::Quantity;
use leafwise::expression::syntax::{Formula, Scope};
use leafwise::expression::{Arithmetic, Expression, Graph, Kernel};
use serde_json::Value;

/// The formula of x and y that a text is.
fn formula(text: &str) -> Expression {
    let scope = Scope::new()
        .with_variables(&["x", "y"])
        .with_parameters(&["a", "b"]);
    let parsed = Formula::parse(text).expect(text);
    parsed.resolve(&scope, None).expect(text).expect(text)
}

/// The value by code at a state.
fn by_code(formula: &Expression, state: [f64; 2]) -> f64 {
    let mut graph = Graph::new();
    let code = formula.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)));
    let kernel = Kernel::compile(&graph, &[code.expect("code")], 0, 2);
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
    let mut value = [0.0];
    kernel.evaluate(&mut workspace, &state, &mut value);
    value[0]
}

fn data() -> Value {
    serde_json::from_str(include_str!("data/functions.json")).expect("reference values")
}

fn number(value: &Value) -> f64 {
    value.as_str().expect("a decimal").parse().expect("a double")
}

/// Most units of 2⁻⁵² by which a derivative may be off, of the value, or of this size where the value is less. Errors of
/// derivatives of elliptic integrals grow with the order below −1 and next to 1.
fn allowed(name: &str, order: u64, x: f64) -> (f64, f64) {
    let order = order as f64;
    match name {
        "erf" | "log10" | "log2" => (1.0, 0.0),
        "erfc" => (1.5, 0.0),
        "gamma" => (2.0, 0.0),
        "lgamma" if order == 0.0 => (4.0, 1e-3),
        "lgamma" => (16.0, 1.0),
        // Of the size of the amplitude.
        "j0" | "j1" => (8.0, if order == 0.0 { 0.3 } else { 1.0 }),
        _ if (-1.0..0.5).contains(&x) => (12.0 + order, 0.0),
        _ => (16.0 * libm::exp2(order), 0.0),
    }
}

/// The worst errors are printed: read them with --nocapture.
#[test]
#[allow(clippy::print_stdout, reason = "measured errors, read with --nocapture")]
fn special_functions_have_the_values_of_mpmath() {
    let data = data();
    let mut count = 0;
    for case in data["functions"].as_array().expect("cases") {
        let name = case["function"].as_str().expect("a name");
        let order = case["derivative"].as_u64().expect("an order");
        let of = match order {
            0 => formula(&format!("{name}(x)")),
            _ => formula(&format!("{name}(x, {order})")),
        };
        let mut worst = (0.0, 0.0);
        for row in case["values"].as_array().expect("values") {
            let (x, exact) = (number(&row[0]), number(&row[1]));
            let found = by_code(&of, [x, 0.0]);
            assert_eq!(found.to_bits(), of.evaluate(&[x, 0.0], &[]).to_bits());
            let (units, least) = allowed(name, order, x);
            let units_off = (found - exact).abs() / (f64::EPSILON * exact.abs().max(least));
            let units_off = if found == exact { 0.0 } else { units_off };
            if units_off > worst.0 {
                worst = (units_off, x);
            }
            if !(units_off <= units) { println!("BAD {name}^({order})({x}) = {found}, not {exact}: {units_off:.1} units");}
            count += 1;
        }
        println!("{name}^({order}): {:.2} units at {}", worst.0, worst.1);
    }
    assert!(count > 3000, "{count}");
}
