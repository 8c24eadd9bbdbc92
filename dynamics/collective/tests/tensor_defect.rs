//! How well collective methods preserve the Poisson tensor.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use crate::common::{Cayley, INTEGRATORS, Rotations, distance, karasev, method, run};
use leafwise_collective::SymplecticIntegrator;
use leafwise_core::diagnostics::{TensorDefect, fit_slope};
use leafwise_core::{Correction, Method, PoissonSystem, RealizationData};

const START: [f64; 3] = [1.0, 1.5, -0.7];
const BOUNDED: [f64; 3] = [1.0, 1.9, 0.5];

fn cayley() -> Arc<dyn RealizationData> {
    Arc::new(Cayley)
}

/// The defect of one step of t, and the size of the tensor.
fn defect(system: &PoissonSystem, method: &Method, t: f64, x: &[f64]) -> (f64, f64) {
    let mut instrument =
        TensorDefect::new(system, method, &[], 1.0, t).expect("a tensor with code");
    let defect = instrument.measure(x).expect("a step that converges");
    (defect.norm, defect.scale)
}

/// Over an exact realization. The tensor is of size 2; DΦ Π DΦᵀ is a sum of nine products of that
/// size, and the solve multiplies round-off by its condition, near 1: 64 u of the tensor is generous.
#[test]
fn the_correction_makes_the_map_poisson() {
    let system = crate::common::rigid_body();
    println!("tensor defect of one step, so(3)*, Cayley chart, from {START:?}");
    println!(
        "{:20} {:>6} {:>12} {:>12}",
        "integrator", "t", "uncorrected", "corrected"
    );
    for integrator in INTEGRATORS {
        let [corrected, uncorrected] = [Correction::Bisection, Correction::None]
            .map(|correction| method(&system, &cayley(), integrator, correction));
        for t in [0.2, 0.1, 0.05] {
            let (without, _) = defect(&system, &uncorrected, t, &START);
            let (with, scale) = defect(&system, &corrected, t, &START);
            println!("{integrator:<20} {t:>6} {without:>12.2e} {with:>12.2e}");
            assert!(
                with <= 64.0 * f64::EPSILON * scale,
                "{integrator}, t = {t}: {with:e}"
            );
        }
    }
    let midpoint = SymplecticIntegrator::ImplicitMidpoint;
    let uncorrected = method(&system, &cayley(), midpoint, Correction::None);
    let (norm, _) = defect(&system, &uncorrected, 0.1, &START);
    assert!((3e-5..3e-4).contains(&norm), "near 1e-4: {norm:e}");
}

/// One step's defect is O(t^{m+1}), and on so(3)* one order better.
#[test]
fn the_uncorrected_map_is_poisson_to_the_integrators_order() {
    let (rigid, lv) = (crate::common::rigid_body(), crate::common::lotka_volterra());
    let cases = [
        ("rigid body", &rigid, cayley(), START, 0.4),
        ("Lotka-Volterra", &lv, karasev(&lv, 10), BOUNDED, 0.1),
    ];
    for (name, system, realization, start, largest) in &cases {
        for integrator in INTEGRATORS {
            let uncorrected = method(system, realization, integrator, Correction::None);
            let points: Vec<_> = (0..6)
                .map(|k| largest * libm::pow(2.0, -0.5 * f64::from(k)))
                .map(|t| (t, defect(system, &uncorrected, t, start).0))
                .collect();
            let Some(slope) = fit_slope(&points, 1e-14) else {
                assert!(integrator.order() > 6, "{name}, {integrator}: {points:?}");
                continue;
            };
            println!("{name}, {integrator}: slope {:.2}", slope.exponent);
            let expected = integrator.order() as f64 + 1.0;
            assert!(
                (expected - 0.35..expected + 1.35).contains(&slope.exponent),
                "{name}, {integrator}: {slope:?}"
            );
        }
    }
}

/// Over the realization truncated after n the corrected map is Poisson to order n: one step's defect
/// is O(t^{n+1}), and better by one where n is odd, since β̂ and α̂ differ by a reflection.
#[test]
fn over_a_truncated_realization_the_defect_is_the_realizations() {
    let system = crate::common::lotka_volterra();
    for n in 1..=4 {
        let realization = karasev(&system, n);
        let integrator = SymplecticIntegrator::Gauss(4);
        let corrected = method(&system, &realization, integrator, Correction::Bisection);
        let points: Vec<_> = (0..6)
            .map(|k| 0.1 * libm::pow(2.0, -0.5 * f64::from(k)))
            .map(|t| (t, defect(&system, &corrected, t, &BOUNDED).0))
            .collect();
        let slope = fit_slope(&points, 1e-14).expect("points above round-off");
        println!("n = {n}: {slope:?} {points:?}");
        assert!(slope.exponent > n as f64 + 1.0 - 0.2, "n = {n}: {slope:?}");
    }
}

/// |x|² = 3.74 over a thousand compensated steps. A step's increment is a cross product of size
/// t‖x‖‖∇H‖, rounded to a few ulps without a preferred sign: √1000 · 0.05 · 16 u.
#[test]
fn the_corrected_map_keeps_the_casimir() {
    let system = crate::common::rigid_body();
    let square = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    for integrator in INTEGRATORS {
        let corrected = method(&system, &cayley(), integrator, Correction::Bisection);
        let end = run(&corrected, 0.05, 1000, &START);
        let drift = (square(&end) / square(&START) - 1.0).abs();
        println!("{integrator}: relative change of |x|^2 {drift:e}");
        assert!(drift <= 32.0 * f64::EPSILON, "{integrator}: {drift:e}");
    }
}

/// Points (R, m) reached through a chart and pairs (x, p) of the same chart give one map: they differ
/// by the round-off of a step.
#[test]
fn a_realization_with_a_chart_gives_the_same_map() {
    let system = crate::common::rigid_body();
    let rotations: Arc<dyn RealizationData> = Arc::new(Rotations);
    for integrator in INTEGRATORS {
        for correction in [Correction::Bisection, Correction::None] {
            let pairs = method(&system, &cayley(), integrator, correction);
            let points = method(&system, &rotations, integrator, correction);
            let (a, b) = (run(&pairs, 0.1, 1, &START), run(&points, 0.1, 1, &START));
            assert!(
                distance(&a, &b) <= 16.0 * f64::EPSILON,
                "{integrator}: {a:?} {b:?}"
            );
            let (through_chart, scale) = defect(&system, &points, 0.1, &START);
            let (without_chart, _) = defect(&system, &pairs, 0.1, &START);
            assert!(
                (through_chart - without_chart).abs() <= 64.0 * f64::EPSILON * scale,
                "{integrator}: {through_chart:e} {without_chart:e}"
            );
        }
    }
}

/// Φ_{−t} ∘ Φ_t is not the identity: symmetric compositions must not take these maps for
/// self-adjoint. The corrected implicit midpoint is the exception, see `midpoint.rs`.
#[test]
fn the_maps_are_not_self_adjoint() {
    let (rigid, lv) = (crate::common::rigid_body(), crate::common::lotka_volterra());
    let cases = [
        ("rigid body", &rigid, cayley(), START),
        ("Lotka-Volterra", &lv, karasev(&lv, 8), BOUNDED),
    ];
    for (name, system, realization, start) in &cases {
        for integrator in INTEGRATORS {
            for correction in [Correction::Bisection, Correction::None] {
                let map = method(system, realization, integrator, correction);
                let there = run(&map, 0.1, 1, start);
                let back = distance(&run(&map, -0.1, 1, &there), start);
                println!("{name}, {integrator}, {correction:?}: {back:.1e}");
                let midpoint =
                    integrator.tableau(3) == SymplecticIntegrator::ImplicitMidpoint.tableau(3);
                if midpoint && correction == Correction::Bisection {
                    assert!(back <= 8.0 * f64::EPSILON, "{name}, {integrator}: {back:e}");
                } else if integrator.order() < 8 {
                    assert!(
                        back > 1e-13,
                        "{name}, {integrator}, {correction:?}: {back:e}"
                    );
                }
            }
        }
    }
}
