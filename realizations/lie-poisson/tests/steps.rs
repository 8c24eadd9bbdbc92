//! Methods over it: Newton converges, tensor and Casimirs stay at round-off.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers are shown with --nocapture"
)]

use std::sync::Arc;

use crate::common::{ALGEBRAS, algebra};
use leafwise_collective::{Collective, SymplecticIntegrator};
use leafwise_core::{Correction, Method, PoissonSystem, RealizationData, StepError, StepMap};
use leafwise_lie_poisson::LiePoisson;
use leafwise_tests::methods::{hamilton_jacobi, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, largest};
use leafwise_tests::realizations::assert_orders;
use leafwise_tests::structure::structure_error;
use proptest::collection::vec;
use proptest::prelude::*;

fn realization(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(LiePoisson::new(system).expect("a linear tensor"))
}

fn start(d: usize) -> Vec<f64> {
    (0..d)
        .map(|i| 1.0 + 0.5 * libm::sin(2.3 * i as f64))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn steps_are_poisson_and_keep_the_casimirs(
        at in 0..ALGEBRAS.len(),
        half_order in 1..=4_usize,
        x in vec(0.3..1.5_f64, 10),
    ) {
        let system = algebra(ALGEBRAS[at]);
        let map = hamilton_jacobi(&system, &realization(&system), 2 * half_order);
        let error = structure_error(&system, &map, 0.1, &x[..system.dimension()]).expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{}: {error:?}", ALGEBRAS[at]);
    }
}

/// Corrected collective integrators over code and, on so(5)*, over numbers with second derivatives.
#[test]
fn collective_steps_are_poisson_and_keep_the_casimirs() {
    for name in ALGEBRAS {
        let system = algebra(name);
        let x = start(system.dimension());
        for integrator in [
            SymplecticIntegrator::StormerVerlet,
            SymplecticIntegrator::Gauss(1),
            SymplecticIntegrator::Gauss(3),
        ] {
            let dynamics = Collective::new(integrator, Correction::Bisection).expect("few stages");
            let map = Method::compose(&system, realization(&system), Arc::new(dynamics));
            let error = structure_error(&system, &map.expect("they fit"), 0.1, &x).expect("a step");
            println!("{name}, {integrator}: {error:?}");
            assert!(
                error.tensor <= 64.0 && error.casimirs <= 64.0,
                "{name}, {integrator}: {error:?}"
            );
        }
    }
}

#[test]
fn newton_converges_over_code_and_over_numbers() {
    for name in ALGEBRAS {
        let system = algebra(name);
        let map = hamilton_jacobi(&system, &realization(&system), 4);
        let path = if name == "so5" {
            "evaluators"
        } else {
            "one kernel"
        };
        assert_eq!(map.path(), path, "{name}");
        let x = start(system.dimension());
        let mut stepper = map.stepper(1, &system.parameter_values(), 1.0, 0.1);
        let (mut state, zero) = (x.clone(), vec![0.0; x.len()]);
        let mut increment = zero.clone();
        for _ in 0..100 {
            let mut outcome = [Ok(())];
            stepper.increment(&state, &zero, &mut increment, &mut outcome);
            assert_eq!(outcome[0], Ok(()), "{name}");
            state.iter_mut().zip(&increment).for_each(|(x, i)| *x += i);
        }
        let work = stepper.statistics();
        println!(
            "{name}: {:.2} evaluations a step, at most {}",
            work.evaluations_per_step(),
            work.most_evaluations
        );
        // The first step takes as many again to confirm its solution by that of half the step.
        assert!(work.most_evaluations <= 20, "{name}: {work:?}");
        // Evaluations without a Jacobian count for what they cost.
        let newton = match map.newton() {
            Some(newton) => {
                let operations = work.operations_per_step().expect("code is counted");
                operations / newton.work() as f64
            }
            None => work.evaluations_per_step(),
        };
        println!("{name}: {newton:.2} of Newton's evaluations a step");
        // Three, and one more in the mean where steps are long (sl2) and their solutions confirmed.
        assert!(newton <= 4.0, "{name}: {newton}");
    }
}

/// Over a thousand steps the Casimirs wander as a random walk of a step's round-off would.
#[test]
fn casimirs_do_not_drift() {
    const STEPS: usize = 1000;
    for name in ALGEBRAS {
        let system = algebra(name);
        let formulas: Vec<_> = system
            .expressions()
            .expect("formulas")
            .casimirs()
            .iter()
            .map(|c| &c.expression)
            .collect();
        let kernel = system
            .expressions()
            .expect("formulas")
            .observable_kernel(&formulas)
            .expect("code");
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &system.parameter_values(), &[1.0], &[1.0]);
        let mut values = |x: &[f64]| {
            let mut values = vec![0.0; formulas.len()];
            kernel.evaluate(&mut workspace, x, &mut values);
            values
        };
        let map = hamilton_jacobi(&system, &realization(&system), 4);
        let x = start(system.dimension());
        let end = run(&system, &map, (1.0, 0.05), STEPS, &x).expect("steps");
        let (before, after) = (values(&x), values(&end));
        for (before, after) in before.iter().zip(&after) {
            let size = largest(x.iter().chain(&end).copied());
            let drift = (after - before).abs() / (size * size);
            println!("{name}: Casimir moved by {drift:.1e} of |x|² in {STEPS} steps");
            assert!(
                drift <= 64.0 * UNIT_ROUNDOFF * libm::sqrt(STEPS as f64),
                "{name}: {drift:e}"
            );
        }
    }
}

#[test]
fn measured_orders_are_those_declared() {
    let orders = [
        (2, [16, 32, 64, 128]),
        (4, [16, 24, 32, 48]),
        (6, [12, 16, 20, 24]),
    ];
    for (name, time) in [("rigid-body", 1.0), ("heavy-top", 1.0), ("sl2", 0.5)] {
        let system = algebra(name);
        let x = start(system.dimension());
        assert_orders(&system, &realization(&system), (&x, time), &orders);
    }
}

/// A step far too large ends in an error, and the state before it is intact.
#[test]
fn a_step_past_the_wall_is_refused() {
    let system = algebra("rigid-body");
    let map = hamilton_jacobi(&system, &realization(&system), 2);
    let outcome = run(&system, &map, (1.0, 40.0), 1, &[1.0, 3.0, 3.0]);
    let refused = matches!(
        outcome,
        Err(StepError::LeftChart { .. }
            | StepError::NoConvergence { .. }
            | StepError::OtherBranch { .. })
    );
    assert!(refused, "{outcome:?}");
}
