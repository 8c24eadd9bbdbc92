//! Orders, and flows to a tolerance.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use crate::common::{
    LOTKA_VOLTERRA_FLOW, RIGID_BODY_FLOW, distance, heavy_top, lotka_volterra, map, none, parts,
    rigid_body, run,
};
use leafwise_core::diagnostics::fit_slope;
use leafwise_core::{PartParameters, PoissonSystem};
use serde_json::Value;

/// Errors are c tᵐ(1 + O(t)) over steps t = 1/N: the order is the whole number nearest to the fitted
/// exponent. Round-off is a few ulps of a state of size 5.
fn measured_order(
    name: &str,
    parameters: &PartParameters,
    order: usize,
    system: &PoissonSystem,
    flow: &([f64; 3], [f64; 3]),
) {
    let map = map(name, system, parameters);
    assert_eq!(map.properties().order, order, "{name} declares its order");
    let counts: &[usize] = match order {
        2 => &[64, 90, 128, 180, 256],
        4 | 5 => &[45, 64, 90, 128, 180],
        6 => &[20, 24, 28, 34, 40],
        _ => &[12, 13, 14, 15, 16, 18],
    };
    let points: Vec<_> = counts
        .iter()
        .map(|&steps| {
            let t = 1.0 / steps as f64;
            (t, distance(&run(map.as_ref(), t, steps, &flow.0), &flow.1))
        })
        .collect();
    let slope = fit_slope(&points, 1e-14).expect("points above round-off");
    println!(
        "{}: order {:.3}, {points:?}",
        map.describe(),
        slope.exponent
    );
    assert!(
        (slope.exponent - order as f64).abs() < 0.5,
        "{}: {slope:?}",
        map.describe()
    );
}

#[test]
fn orders_on_the_rigid_body() {
    let system = rigid_body();
    for (name, parameters, order) in parts() {
        measured_order(name, &parameters, order, &system, &RIGID_BODY_FLOW);
    }
    measured_order("spherical-midpoint", &none(), 2, &system, &RIGID_BODY_FLOW);
}

#[test]
fn orders_on_a_periodic_lotka_volterra() {
    let system = lotka_volterra();
    for (name, parameters, order) in parts() {
        measured_order(name, &parameters, order, &system, &LOTKA_VOLTERRA_FLOW);
    }
}

/// Errors of substeps add up: a few tens of them, amplified a little, stay below a hundred
/// tolerances, and round-off of as many substeps below 1e-13.
fn reaches_its_tolerance(system: &PoissonSystem, initial: &[f64], end: &[f64], steps: usize) {
    // At order 5 the substeps number some tens down to 1e-8.
    let low = [1e-2, 1e-4, 1e-6, 1e-8].map(|tolerance| ("dormand-prince45", tolerance));
    let high = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14].map(|tolerance| ("dop853", tolerance));
    for (part, tolerance) in low.into_iter().chain(high) {
        let map = map(part, system, &none().with("tolerance", tolerance));
        let found = run(map.as_ref(), 1.0 / steps as f64, steps, initial);
        let error = distance(&found, end);
        println!("{}: {steps} steps, error {error:e}", map.describe());
        assert!(
            error < 100.0 * tolerance + 1e-13,
            "{tolerance:e}: {error:e}"
        );
    }
}

#[test]
fn adaptive_pairs_reach_their_tolerance() {
    for steps in [1, 7] {
        let (start, end) = &RIGID_BODY_FLOW;
        reaches_its_tolerance(&rigid_body(), start, end, steps);
        let (start, end) = &LOTKA_VOLTERRA_FLOW;
        reaches_its_tolerance(&lotka_volterra(), start, end, steps);
    }
}

/// The heavy top's flow of 25 digits.
#[test]
fn dop853_reaches_the_reference_flow_of_the_heavy_top() {
    let text = include_str!("../../../systems/reference/flows.json");
    let data: Value = serde_json::from_str(text).expect("reference data");
    let flows = data["flows"].as_array().expect("a list of flows");
    let flow = flows.iter().find(|flow| flow["system"] == "heavy-top");
    let flow = flow.expect("a flow of the heavy top");
    let numbers = |value: &Value| -> Vec<f64> {
        let list = value.as_array().expect("a list").iter();
        list.map(|v| v.as_str().expect("a decimal").parse().expect("a number"))
            .collect()
    };
    let system = heavy_top();
    reaches_its_tolerance(
        &system,
        &numbers(&flow["initial"]),
        &numbers(&flow["final"]),
        3,
    );
}
