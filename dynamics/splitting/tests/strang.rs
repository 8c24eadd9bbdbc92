//! Strang's product, and compositions over it.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::common::{
    Problem, assert_conserved, distance, gauss, largest, library, run, step, volterra,
};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::diagnostics::{TensorDefect, fit_slope};
use leafwise_core::registry::Registry;
use leafwise_core::solver::{StepMap, Structure};
use leafwise_core::{PartParameters, PoissonSystem, Walk};
use leafwise_splitting as _;

fn systems() -> Vec<Problem> {
    let mut systems: Vec<Problem> = [
        "rigid-body",
        "lotka-volterra-periodic",
        "heavy-top",
        "magnetic",
        "so4",
        "se3",
        "point-vortices",
    ]
    .map(library)
    .into();
    systems.push(volterra(8));
    systems
}

/// Strang's product for a system, formed once for all claims: to split so(4) takes seconds.
fn strang(system: &PoissonSystem) -> Arc<dyn StepMap> {
    static FORMED: Mutex<BTreeMap<String, Arc<dyn StepMap>>> = Mutex::new(BTreeMap::new());
    let form = || {
        let registry = Registry::with_builtin();
        let part = registry.stepper("splitting").expect("a built-in stepper");
        part.build(system, &PartParameters::new())
            .expect("a system that splits")
    };
    let mut formed = FORMED.lock().expect("no claim failed while forming");
    Arc::clone(formed.entry(format!("{system:?}")).or_insert_with(form))
}

fn composed(base: Arc<dyn StepMap>, name: &str) -> Composed {
    Composed::new(base, Scheme::find(name).expect("a scheme"))
        .expect("Strang's product is self-adjoint")
}

/// The slope of global errors over `time`; errors under 20 ulps of the state are round-off.
fn order(problem: &Problem, map: &dyn StepMap, time: f64, steps: &[usize]) -> f64 {
    let system = problem.system();
    let exact = gauss(&system, &problem.initial, time, 200);
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&steps| {
            let end = run(&system, map, &problem.initial, time, steps).expect("finite");
            (
                time / steps as f64,
                distance(&end, &exact) / largest(&exact),
            )
        })
        .collect();
    let slope = fit_slope(&points, 20.0 * f64::EPSILON).expect("points above round-off");
    println!("{}: {} {points:?}", problem.id, slope.exponent);
    slope.exponent
}

#[test]
fn strang_has_order_2() {
    for problem in systems() {
        let map = strang(&problem.system());
        assert_eq!(map.properties().order, 2);
        assert_eq!(map.properties().structure, Structure::Exact);
        let measured = order(&problem, map.as_ref(), 1.0, &[32, 45, 64, 90, 128]);
        assert!((measured - 2.0).abs() < 0.1, "{}: {measured}", problem.id);
    }
}

/// The windows lie between the pre-asymptotic range and round-off: errors from 1e-6 to 1e-13.
#[test]
fn suzuki_umeno_8_over_strang_has_order_8() {
    for (problem, steps) in [
        (library("rigid-body"), [4, 5, 6, 7, 8]),
        (library("lotka-volterra-periodic"), [16, 19, 22, 27, 32]),
        (library("heavy-top"), [12, 14, 16, 19, 22]),
    ] {
        let map = composed(strang(&problem.system()), "suzuki-umeno-8");
        assert_eq!(map.properties().order, 8);
        assert_eq!(map.properties().structure, Structure::Exact);
        let measured = order(&problem, &map, 1.0, &steps);
        assert!((measured - 8.0).abs() < 0.5, "{}: {measured}", problem.id);
    }
}

/// Over two pieces, three and more; the errors of the windows lie between 3e-6 and 4e-16.
#[test]
fn compositions_of_the_factors_have_their_orders() {
    for (name, expected, steps) in [
        ("blanes-moan-4", 4, [8, 11, 16, 23, 32]),
        ("blanes-moan-6", 6, [3, 4, 5, 6, 8]),
    ] {
        for id in ["rigid-body", "lotka-volterra-periodic", "heavy-top", "so4"] {
            let problem = library(id);
            let map = composed(strang(&problem.system()), name);
            assert_eq!(map.properties().order, expected);
            assert_eq!(map.properties().self_adjoint, Some(true));
            let measured = order(&problem, &map, 1.0, &steps);
            let error = (measured - expected as f64).abs();
            assert!(error < 0.5, "{name}, {id}: {measured}");
        }
    }
}

/// A composition is one kernel whose flows that meet are one; the same factors one after the other
/// differ by round-off: each flow rounds its increment and the state once, and later ones let that grow.
#[test]
fn a_composition_is_the_product_of_its_factors() {
    for problem in systems() {
        let system = problem.system();
        let parameters = system.parameter_values();
        let base = strang(&system);
        let factors = base
            .abilities()
            .factored
            .expect("a product of flows and its adjoint")
            .factors;
        for (name, stages) in [("kahan-li-8", 17.0), ("blanes-moan-6", 10.0)] {
            let scheme = Scheme::find(name).expect("a scheme");
            let whole = composed(Arc::clone(&base), name);
            let mut one = whole.stepper(1, &parameters, 1.0, problem.time_step);
            let found = step(one.as_mut(), &problem.initial).expect("finite");
            assert_eq!(one.statistics().evaluations_per_step(), stages);
            let mut x = problem.initial.clone();
            let mut operations = 0;
            for (at, part) in scheme.coefficients().into_iter().enumerate() {
                let map = if scheme.takes_factors() {
                    &factors[at % 2]
                } else {
                    &base
                };
                let mut factor = map.stepper(1, &parameters, 1.0, part * problem.time_step);
                x = step(factor.as_mut(), &x).expect("finite");
                operations += factor.statistics().operations.expect("counted");
            }
            let error = distance(&found, &x) / largest(&x);
            println!("{}, {name}: {error:.1e}", problem.id);
            assert!(error <= 64.0 * f64::EPSILON, "{}: {error:e}", problem.id);
            let fused = one.statistics().operations.expect("counted");
            assert!(fused < operations, "{}: {fused} {operations}", problem.id);
        }
    }
}

/// DΦ Π DΦᵀ − Π∘Φ of one step of Strang and of order 8. The tangent is a sum of products over the
/// flows of a step; 64 units of round-off of its size, a stage.
#[test]
fn steps_are_poisson_maps() {
    for problem in systems() {
        let system = problem.system();
        let parameters = system.parameter_values();
        let base = strang(&system);
        let eighth = composed(Arc::clone(&base), "suzuki-umeno-8");
        for (map, stages) in [(base.as_ref(), 1.0), (&eighth as &dyn StepMap, 15.0)] {
            let h = problem.time_step;
            let mut instrument =
                TensorDefect::new(&system, map, &parameters, 1.0, h).expect("a tensor");
            let defect = instrument.measure(&problem.initial).expect("finite");
            let growth = largest(&defect.tangent);
            println!(
                "{}: {}: defect {:.1e} of {:.1e}",
                problem.id,
                map.describe(),
                defect.norm,
                defect.scale
            );
            let bound = 64.0 * stages * f64::EPSILON * defect.scale * growth * growth;
            assert!(
                defect.norm <= bound,
                "{}: {:e} > {bound:e}",
                problem.id,
                defect.norm
            );
        }
    }
}

/// The tangent against central differences: δ² ≈ 1e-10 and ulps over δ.
#[test]
fn the_tangent_is_that_of_the_map() {
    for problem in systems() {
        let system = problem.system();
        let d = system.dimension();
        let map = strang(&system);
        let mut stepper = map.stepper(1, &system.parameter_values(), 1.0, problem.time_step);
        step(stepper.as_mut(), &problem.initial).expect("finite");
        let tangent = stepper.tangent(0).expect("a tangent");
        let delta = 1e-5;
        for j in 0..d {
            let [above, below] = [delta, -delta].map(|shift| {
                let mut x = problem.initial.clone();
                x[j] += shift;
                step(stepper.as_mut(), &x).expect("finite")
            });
            for i in 0..d {
                let slope = (above[i] - below[i]) / (2.0 * delta);
                let error = (slope - tangent[i * d + j]).abs();
                assert!(error < 1e-8, "{} ({i}, {j}): {error:e}", problem.id);
            }
        }
    }
}

#[test]
fn casimirs_stay_at_round_off() {
    for problem in systems() {
        assert_conserved(&problem, strang(&problem.system()).as_ref(), &[]);
    }
}

/// One step and the step back, cold: a rounded state, and the growth of a step; a composition of s stages
/// rounds its state between s times as often.
#[test]
fn strang_and_compositions_of_its_factors_are_self_adjoint() {
    for problem in systems() {
        let system = problem.system();
        let parameters = system.parameter_values();
        let strang = strang(&system);
        let composed = composed(Arc::clone(&strang), "blanes-moan-6");
        for (map, stages) in [(strang.as_ref(), 1.0), (&composed as &dyn StepMap, 10.0)] {
            let there = step(
                map.stepper(1, &parameters, 1.0, 0.1).as_mut(),
                &problem.initial,
            );
            let back = step(
                map.stepper(1, &parameters, 1.0, -0.1).as_mut(),
                &there.expect("finite"),
            );
            let defect =
                distance(&back.expect("finite"), &problem.initial) / largest(&problem.initial);
            let bound = 16.0 * stages * f64::EPSILON;
            assert!(defect <= bound, "{}: {defect:e}", problem.id);
        }
    }
}

#[test]
fn a_step_costs_one_evaluation_and_lanes_have_the_bits_they_have_alone() {
    let problem = library("heavy-top");
    let system = problem.system();
    let parameters = system.parameter_values();
    let map = strang(&system);
    let lanes = 8;
    let many: Vec<f64> = parameters.iter().flat_map(|p| vec![*p; lanes]).collect();
    let mut wide = map.stepper(lanes, &many, 1.0, 0.1);
    let mut x = vec![0.0; 6 * lanes];
    for (at, value) in x.iter_mut().enumerate() {
        *value = problem.initial[at / lanes] + (at % lanes) as f64 / 16.0;
    }
    let mut increment = vec![0.0; 6 * lanes];
    let mut outcome = vec![Ok(()); lanes];
    wide.increment(&x, &vec![0.0; 6 * lanes], &mut increment, &mut outcome);
    for lane in 0..lanes {
        let own: Vec<f64> = x.iter().skip(lane).step_by(lanes).copied().collect();
        let mut alone = map.stepper(1, &parameters, 1.0, 0.1);
        let end = step(alone.as_mut(), &own).expect("finite");
        for i in 0..6 {
            let at = i * lanes + lane;
            assert_eq!((x[at] + increment[at]).to_bits(), end[i].to_bits());
        }
        assert_eq!(alone.tangent(0), wide.tangent(lane));
    }
    assert_eq!(wide.statistics().evaluations_per_step(), 1.0);
}

#[test]
fn a_restored_run_continues_to_the_same_bits() {
    let problem = library("so4");
    let system = problem.system();
    let parameters = system.parameter_values();
    let map = composed(strang(&system), "kahan-li-6");
    let mut whole = Walk::new(&map, &parameters, 1.0, 0.1, &problem.initial);
    for _ in 0..10 {
        whole.step().expect("finite");
    }
    let mut resumed = Walk::new(&map, &parameters, 1.0, 0.1, &problem.initial);
    resumed
        .restore(&whole.checkpoint())
        .expect("the same method");
    for _ in 0..10 {
        whole.step().expect("finite");
        resumed.step().expect("finite");
    }
    assert_eq!(whole.checkpoint(), resumed.checkpoint());
}
