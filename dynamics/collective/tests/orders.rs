//! The order of a collective method in t = εh is that of its symplectic integrator.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use crate::common::{
    INTEGRATORS, LOTKA_VOLTERRA_FLOW, RIGID_BODY_FLOW, distance, karasev, method, run,
};
use leafwise_core::diagnostics::fit_slope;
use leafwise_core::{Correction, PoissonSystem};

/// Errors are c tᵐ(1 + O(t²)) over steps t = 1/N: the order is the whole number nearest to the fitted
/// exponent. Round-off is a few ulps of a state of size 5.
fn measured_orders(name: &str, system: &PoissonSystem, flow: ([f64; 3], [f64; 3])) {
    for integrator in INTEGRATORS {
        let m = integrator.order();
        let counts: &[usize] = match m {
            2 => &[64, 90, 128, 180, 256],
            4 => &[32, 45, 64, 90, 128],
            6 => &[20, 24, 28, 34, 40],
            _ => &[12, 13, 14, 15, 16, 18],
        };
        let realization = karasev(system, m + 4);
        for correction in [Correction::Bisection, Correction::None] {
            let method = method(system, &realization, integrator, correction);
            let points: Vec<_> = counts
                .iter()
                .map(|&steps| {
                    let t = 1.0 / steps as f64;
                    let end = run(&method, t, steps, &flow.0);
                    (t, distance(&end, &flow.1))
                })
                .collect();
            let slope = fit_slope(&points, 1e-14).expect("points above round-off");
            println!(
                "{name}, {integrator}, {correction:?}: order {:.3}, {points:?}",
                slope.exponent
            );
            assert!(
                (slope.exponent - m as f64).abs() < 0.5,
                "{name}, {integrator}, {correction:?}: {slope:?}"
            );
        }
    }
}

#[test]
fn the_order_is_the_integrators_on_the_rigid_body() {
    measured_orders("rigid body", &crate::common::rigid_body(), RIGID_BODY_FLOW);
}

#[test]
fn the_order_is_the_integrators_on_a_periodic_lotka_volterra() {
    let system = crate::common::lotka_volterra();
    measured_orders("Lotka-Volterra", &system, LOTKA_VOLTERRA_FLOW);
}
