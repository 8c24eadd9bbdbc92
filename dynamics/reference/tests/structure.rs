//! What each method preserves, and what it does not.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use crate::common::{
    distance, drift, heavy_top, lotka_volterra, map, none, orbit, parts, pendulum, rigid_body, run,
    spins,
};
use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::{Method, PoissonSystem, StepMap, Structure};
use leafwise_hamilton_jacobi::HamiltonJacobi;
use leafwise_karasev::TruncatedKarasev;

const SPINS: [f64; 6] = [0.6, 0.0, 0.8, -0.48, 0.6, 0.64];
const TOP: [f64; 6] = [0.5, 1.0, 1.5, 0.6, 0.0, 0.8];
const ORBIT: [f64; 3] = [1.0, 1.9, 0.5];

/// Values along an orbit of compensated steps, whose round-off is a random walk of roundings of an
/// increment: √1000 steps · 0.1 · a few u, and the rounding of the state in evaluating the function.
const ROUND_OFF: f64 = 32.0 * f64::EPSILON;

#[test]
fn energy_preserving_methods_keep_the_energy() {
    let cases: [(&str, PoissonSystem, &[f64]); 4] = [
        ("rigid body", rigid_body(), &[1.0, 3.0, 3.0]),
        ("Lotka-Volterra", lotka_volterra(), &ORBIT),
        ("heavy top", heavy_top(), &TOP),
        ("pendulum", pendulum(), &[1.0, 0.5, 0.3, 0.2]),
    ];
    for (name, system, start) in &cases {
        for order in [2, 4] {
            let map = map("energy-preserving", system, &none().with("order", order));
            let states = orbit(map.as_ref(), 0.1, 1000, start);
            let drift = drift(
                &states,
                system.expressions().expect("formulas").hamiltonian(),
            );
            println!("{name}, order {order}: energy {drift:e}");
            assert!(drift <= ROUND_OFF, "{name}, order {order}: {drift:e}");
        }
    }
}

/// The Casimirs of the rigid body and the heavy top are quadratic.
#[test]
fn energy_preserving_methods_keep_quadratic_casimirs() {
    for (system, start) in [(rigid_body(), &[1.0, 3.0, 3.0][..]), (heavy_top(), &TOP)] {
        for order in [2, 4] {
            let map = map("energy-preserving", &system, &none().with("order", order));
            let states = orbit(map.as_ref(), 0.1, 1000, start);
            for casimir in system.expressions().expect("formulas").casimirs() {
                let drift = drift(&states, &casimir.expression);
                println!("order {order}, {}: {drift:e}", casimir.name);
                assert!(drift <= ROUND_OFF, "order {order}: {drift:e}");
            }
        }
    }
}

#[test]
fn the_spherical_midpoint_keeps_every_sphere() {
    for (system, start) in [(rigid_body(), &[1.0, 3.0, 3.0][..]), (spins(), &SPINS)] {
        let map = map("spherical-midpoint", &system, &none());
        let states = orbit(map.as_ref(), 0.1, 1000, start);
        for casimir in system.expressions().expect("formulas").casimirs() {
            let drift = drift(&states, &casimir.expression);
            println!("{}: {drift:e}", casimir.name);
            assert!(drift <= ROUND_OFF, "{drift:e}");
        }
    }
}

#[test]
fn projection_keeps_energy_and_casimirs() {
    let cases: [(&str, PoissonSystem, &[f64]); 3] = [
        ("rigid body", rigid_body(), &[1.0, 3.0, 3.0]),
        ("Lotka-Volterra", lotka_volterra(), &ORBIT),
        ("heavy top", heavy_top(), &TOP),
    ];
    for (name, system, start) in &cases {
        for base in ["rk4", "gauss"] {
            let map = map("projection", system, &none().with("base", base));
            let states = orbit(map.as_ref(), 0.05, 1000, start);
            let casimirs = system
                .expressions()
                .expect("formulas")
                .casimirs()
                .iter()
                .map(|c| &c.expression);
            for invariant in std::iter::once(system.expressions().expect("formulas").hamiltonian())
                .chain(casimirs)
            {
                let drift = drift(&states, invariant);
                println!("{name}, {base}: {drift:e}");
                // A projection solves to the rounding of the invariants, not of an increment:
                // a random walk of a thousand of those.
                assert!(drift <= 256.0 * f64::EPSILON, "{name}, {base}: {drift:e}");
            }
        }
    }
}

/// At an equilibrium the gradients of energy and Casimir are parallel.
#[test]
fn projection_stays_at_an_equilibrium() {
    let map = map("projection", &rigid_body(), &none());
    assert_eq!(run(map.as_ref(), 0.1, 3, &[0.0, 2.0, 0.0]), [0.0, 2.0, 0.0]);
}

/// Over a constant tensor S_1 alone is the implicit midpoint rule.
#[test]
fn over_a_constant_tensor_the_midpoint_rule_is_hamilton_jacobi() {
    let (system, start) = (pendulum(), [1.0, 0.5, 0.3, 0.2]);
    let realization = Arc::new(TruncatedKarasev::new(&system, 1).expect("an order"));
    let dynamics = Arc::new(HamiltonJacobi::new(2).expect("an even order"));
    let jacobi = Method::compose(&system, realization, dynamics).expect("they fit");
    let midpoint = map("implicit-midpoint", &system, &none());
    let (a, b) = (
        run(&jacobi, 0.2, 20, &start),
        run(midpoint.as_ref(), 0.2, 20, &start),
    );
    assert!(distance(&a, &b) <= 16.0 * f64::EPSILON, "{a:?} {b:?}");
}

fn defect(system: &PoissonSystem, map: &dyn StepMap, x: &[f64]) -> Option<f64> {
    let mut instrument = TensorDefect::new(system, map, &[], 1.0, 0.1).expect("a tensor");
    let defect = instrument.measure(x).ok()?;
    Some(defect.norm / defect.scale)
}

/// A map that declares itself Poisson has a tensor defect of round-off, one that does not has one of
/// its order: that the declarations are neither too good nor too modest.
#[test]
fn declarations_of_structure_are_true() {
    let cases: [(&str, PoissonSystem, &[f64]); 5] = [
        ("rigid body", rigid_body(), &[1.0, 3.0, 3.0]),
        ("Lotka-Volterra", lotka_volterra(), &ORBIT),
        ("heavy top", heavy_top(), &TOP),
        ("spins", spins(), &SPINS),
        ("pendulum", pendulum(), &[1.0, 0.5, 0.3, 0.2]),
    ];
    for (name, system, start) in &cases {
        let mut parts = parts();
        parts.retain(|(_, _, order)| *order <= 4);
        if name.contains("rigid") || name.contains("spins") {
            parts.push(("spherical-midpoint", none(), 2));
        }
        for (part, parameters, _) in &parts {
            let map = map(part, system, parameters);
            let Some(defect) = defect(system, map.as_ref(), start) else {
                assert!(
                    ["dop853", "dormand-prince45", "projection"].contains(part),
                    "{part}"
                );
                continue;
            };
            println!("{name}, {}: {defect:.1e}", map.describe());
            match map.properties().structure {
                Structure::Exact => assert!(defect <= 64.0 * f64::EPSILON, "{defect:e}"),
                _ => assert!(defect > 1e-12, "{name}, {part}: {defect:e}"),
            }
        }
    }
}

/// On a system without quadratic invariants; there Gauss methods, projected, would be themselves.
#[test]
fn declarations_of_self_adjointness_are_true() {
    let (lv, spins) = (lotka_volterra(), spins());
    let mut cases: Vec<_> = parts()
        .into_iter()
        .map(|(part, parameters, _)| (part, parameters, &lv, &ORBIT[..]))
        .collect();
    cases.push(("spherical-midpoint", none(), &spins, &SPINS));
    for (part, parameters, system, start) in cases {
        let map = map(part, system, &parameters);
        let there = run(map.as_ref(), 0.2, 1, start);
        let back = distance(&run(map.as_ref(), -0.2, 1, &there), start);
        println!("{}: {back:.1e}", map.describe());
        match map.properties().self_adjoint {
            Some(true) => assert!(back <= 16.0 * f64::EPSILON, "{part}: {back:e}"),
            _ => assert!(back > 1e-13, "{part}: {back:e}"),
        }
    }
}

/// Against central differences of fourth order, (8(f₁ − f₋₁) − (f₂ − f₋₂))/12δ: truncation δ⁴ and
/// round-off u/δ are near 1e-12 at δ = 1e-3.
#[test]
fn tangents_are_those_of_the_maps() {
    let (system, start) = (spins(), SPINS);
    let mut parts = parts();
    parts.push(("spherical-midpoint", none(), 2));
    for (part, parameters, _) in &parts {
        let map = map(part, &system, parameters);
        let mut stepper = map.stepper(1, &[], 1.0, 0.2);
        let mut increment = [0.0; 6];
        stepper.increment(&start, &[0.0; 6], &mut increment, &mut [Ok(())]);
        let Some(tangent) = stepper.tangent(0) else {
            continue;
        };
        let delta = 1e-3;
        for j in 0..6 {
            let at = |steps: f64| {
                let mut x = start;
                x[j] += steps * delta;
                run(map.as_ref(), 0.2, 1, &x)
            };
            let (f1, b1, f2, b2) = (at(1.0), at(-1.0), at(2.0), at(-2.0));
            for i in 0..6 {
                let slope = (8.0 * (f1[i] - b1[i]) - (f2[i] - b2[i])) / (12.0 * delta);
                let error = (slope - tangent[6 * i + j]).abs();
                assert!(error < 1e-10, "{part}, ({i}, {j}): {error:e}");
            }
        }
    }
}
