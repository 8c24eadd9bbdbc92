//! Every value of `data/reference.json`, computed elsewhere at 120 digits by two independent
//! programs, through the public interface.
//!
//! Each claim prints its largest error; `cargo test --test claims reference -- --nocapture` shows them.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::PoissonSystem;
use leafwise::core::dynamics::Generating;
use leafwise::expression::graph::lift;
use leafwise::expression::{Arithmetic, Graph, Rational, Term};
use leafwise_hamilton_jacobi::coefficients::{generating_code, generating_function};
use leafwise_tests::coefficients::natural_size;
use leafwise_tests::methods::{evaluate, run};
use leafwise_tests::numbers::{
    UNIT_ROUNDOFF, decimal, decimals, distance, largest, relative_error,
};
use leafwise_tests::{coefficients, library, method, realization};
use serde_json::Value;

fn cases(kind: &str) -> Vec<Value> {
    let all: Vec<Value> =
        serde_json::from_str(include_str!("data/reference.json")).expect("reference data");
    let chosen: Vec<Value> = all
        .into_iter()
        .filter(|case| case["kind"] == kind)
        .collect();
    assert!(!chosen.is_empty(), "there are cases of the kind {kind}");
    chosen
}

fn system(case: &Value) -> PoissonSystem {
    let id = match case["system"].as_str() {
        Some("so3") => "rigid-body",
        Some("lv") => "lotka-volterra",
        Some("cohen_hairer") => "lotka-volterra-periodic",
        Some(other) => other,
        None => panic!("a case names its system"),
    };
    library(id).system
}

fn integer(value: &Value) -> usize {
    let value = value.as_u64().expect("a whole number");
    usize::try_from(value).expect("a small one")
}

/// The coefficients α_(0) … α_(n) at a point given in exact decimals: the curve in the exact ring,
/// with only the parameters left to evaluate in doubles.
fn exact_coefficients(system: &PoissonSystem, case: &Value, order: usize) -> Vec<f64> {
    let [x, p] = ["x", "p"].map(|key| -> Vec<Rational> {
        let texts = case[key].as_array().expect("a list").iter();
        let texts = texts.map(|text| text.as_str().expect("reference numbers are strings"));
        texts
            .map(|text| Rational::parse_decimal(text).expect("a decimal"))
            .collect()
    });
    let (ring, values) = coefficients::exact(system, order, &x, &p);
    let mut graph = Graph::new();
    let one = graph.one();
    let outputs: Vec<_> = values
        .into_iter()
        .map(|value| vec![(one.clone(), value)])
        .collect();
    let y: Vec<Term> = (0..x.len()).map(|i| graph.input(i)).collect();
    let code = lift(&mut graph, &ring, &outputs, &y).expect("code");
    evaluate(system, &graph, &code, &vec![0.0; x.len()])
}

/// Exact arithmetic leaves one rounding, and where there are parameters a sum of a few powers of
/// them: 1e-13 holds with room. Entries that are 0 are measured against the largest of their order;
/// where a whole order vanishes (odd ones on so(3)*) it must be 0.
///
/// The compiled code is measured beside it by its natural size, which makes it the error of α̂ in
/// units of the state: cancellation between its summands (at the second Lotka–Volterra point order
/// 8 is 10⁻³ of them) costs digits of a coefficient, not of α̂. Two roundings of α̂ itself: 4 u.
#[test]
fn karasev_coefficients_agree_to_thirteen_digits() {
    for case in cases("karasev_coefficients") {
        let system = system(&case);
        let (x, p) = (decimals(&case["x"]), decimals(&case["p"]));
        let (d, order) = (system.dimension(), integer(&case["order"]));
        let all = exact_coefficients(&system, &case, order);
        let compiled = coefficients::compiled(&system, order, &x, &p);
        let (mut worst, mut worst_compiled) = (0.0_f64, 0.0_f64);
        for k in 0..=order {
            let expected = decimals(&case["alpha"][k]);
            let (exact, compiled) = (&all[k * d..][..d], &compiled[k * d..][..d]);
            let size = largest(&expected);
            let error = relative_error(exact, &expected, size);
            assert!(
                error <= 1e-13,
                "{} at order {k}: {exact:?} {expected:?}",
                case["system"]
            );
            worst = worst.max(error);
            let error = distance(compiled, &expected) / natural_size(&all, d, k);
            assert!(
                error <= 4.0 * UNIT_ROUNDOFF,
                "{} at order {k}: {compiled:?} {expected:?}",
                case["system"]
            );
            worst_compiled = worst_compiled.max(error);
        }
        let name = &case["system"];
        println!("{name} n = {order}: exact {worst:.1e}, compiled {worst_compiled:.1e}");
    }
}

/// 1e-12 relative: exact rationals, each rounded once; then sums of at most 82 (S) and 164 (dS)
/// monomials of eight factors and one logarithm, whose cancellation is at most tenfold here; as
/// code at most some 10² nodes deep.
#[test]
fn hamilton_jacobi_coefficients_agree_to_twelve_digits() {
    for case in cases("hamilton_jacobi") {
        let system = system(&case);
        let x = decimals(&case["x"]);
        let orders = case["S"].as_object().expect("S by its order");
        let last: usize = orders
            .keys()
            .map(|l| l.parse().expect("an order"))
            .max()
            .expect("some S_l");
        let part = realization(&system, 1);
        let series = part
            .abilities()
            .series
            .expect("Karasev's chart has a series");
        let expanded = generating_function(&system, &series, last + 1).expect("the exact algebra");
        let code = generating_code(&system, &series, last + 1).expect("code");
        let forms = [
            ("expanded", Generating::Polynomials(expanded)),
            ("as code", Generating::Code(code)),
        ];
        for (l, expected) in orders {
            let index = (l.parse::<usize>().expect("an order") - 1) / 2;
            for (form, generating) in &forms {
                let mut graph = Graph::new();
                let y: Vec<Term> = (0..x.len()).map(|i| graph.input(i)).collect();
                let code = generating.coefficient(&mut graph, index, &y).expect("code");
                let found = evaluate(&system, &graph, &code, &x);
                let gradient = decimals(&expected["dS"]);
                let value = relative_error(&found[..1], &[decimal(&expected["S"])], 1.0);
                let slope = relative_error(&found[1..], &gradient, largest(&gradient));
                let name = format!("{} S_{l} {form}", case["system"]);
                println!("{name}: {value:.1e}, dS_{l}: {slope:.1e}");
                assert!(value <= 1e-12 && slope <= 1e-12, "{name}: {found:?}");
            }
        }
    }
}

/// 1e-13 relative to each component: the increment carries the round-off of the residual, some
/// 10² operations, through a solve whose condition number is below 10 at these steps.
#[test]
fn khj_steps_agree_to_thirteen_digits() {
    for case in cases("khj_step") {
        let system = system(&case);
        let (n, m) = (
            integer(&case["realization_order"]),
            integer(&case["hj_order"]),
        );
        let sizes = (decimal(&case["epsilon"]), decimal(&case["h"]));
        let method = method(&system, n, m);
        let found = run(&system, &method, sizes, 1, &decimals(&case["x"])).expect("a step");
        let error = relative_error(&found, &decimals(&case["next"]), 1.0);
        println!(
            "{} n = {n} m = {m}: relative error {error:.1e}",
            case["system"]
        );
        assert!(error <= 1e-13, "{}: {found:?}", case["system"]);
    }
}
