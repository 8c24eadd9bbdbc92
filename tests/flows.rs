//! M over systems with functions and in six dimensions, against flows of 25 digits.
//!
//! The data of `systems/reference/flows.json` was integrated elsewhere from the literature's
//! equations of motion, so that signs and conventions are tested too.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise_tests::methods::run;
use leafwise_tests::numbers::{decimal, decimals, distance, largest};
use leafwise_tests::orders::measure;
use leafwise_tests::{gauss, library, method};
use serde_json::Value;

fn flows() -> Vec<Value> {
    let text = include_str!("../systems/reference/flows.json");
    let data: Value = serde_json::from_str(text).expect("reference data");
    data["flows"].as_array().expect("a list of flows").clone()
}

fn name(flow: &Value) -> &str {
    flow["system"].as_str().expect("a flow names its system")
}

/// Order 8 in t with n = 12. Six dimensions take milliseconds a step at n = 12: few, large steps.
/// Round-off: a few ulps of the state. The final bound is the claim, 1e-10.
fn against_the_flow(id: &str, steps: &[usize]) {
    let all = flows();
    let flow = all
        .iter()
        .find(|flow| name(flow) == id)
        .expect("a flow of this system");
    let problem = library(id);
    assert_eq!(
        problem.initial,
        decimals(&flow["initial"]),
        "{id} starts at its default"
    );
    let (end, time) = (decimals(&flow["final"]), decimal(&flow["time"]));
    let method = method(&problem.system, 12, 8);
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&steps| {
            let t = time / steps as f64;
            let found = run(&problem.system, &method, (1.0, t), steps, &problem.initial);
            let found = found.expect("every step converges");
            (t, distance(&found, &end) / largest(&end))
        })
        .collect();
    println!("{id}: (t, error) {points:?}");
    let last = points[points.len() - 1].1;
    assert!(last <= 1e-10, "{id}: final error {last:e}");
    let measured = measure(&points, 4.0 * f64::EPSILON, 2.0).expect("points above round-off");
    println!("{id}: order {measured}");
    assert!(measured.is(8.0, 2.0), "{id}: {measured}");
}

#[test]
fn the_heavy_top_follows_its_flow_with_order_8() {
    against_the_flow("heavy-top", &[3, 4, 5, 7, 9, 12]);
}

#[test]
fn the_four_dimensional_body_follows_its_flow_with_order_8() {
    against_the_flow("so4", &[1, 2, 3, 4, 5, 6]);
}

#[test]
fn the_gradient_bracket_follows_its_flow_with_order_8() {
    against_the_flow("gradient", &[4, 6, 8, 11, 16, 22]);
}

/// Checks the oracle of the order claims on systems it was not written for. 64 steps of order 12
/// leave less than 1e-15; 20 ulps for the fixed points and the rounding of the data.
#[test]
fn the_gauss_oracle_agrees_with_every_flow() {
    for flow in flows() {
        let problem = library(name(&flow));
        let end = decimals(&flow["final"]);
        let found = gauss::flow(
            &problem.system,
            &problem.initial,
            decimal(&flow["time"]),
            64,
        );
        // A driven system has the time and its energy behind its coordinates.
        let error = distance(&found[..end.len()], &end) / largest(&end);
        println!("{}: {error:.1e}", name(&flow));
        assert!(error <= 20.0 * f64::EPSILON, "{}: {error:e}", name(&flow));
    }
}
