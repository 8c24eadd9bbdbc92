//! Where the solves of Newton's method start.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::{Method, PartParameters, PoissonSystem, Registry, StepMap, Walk};
use leafwise_tests::library;
use leafwise_tests::numbers::distance;

const INITIAL: [f64; 3] = [1.0, 3.0, 3.0];

fn method(system: &PoissonSystem, realization: &str, m: i64) -> Method {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    let realization = registry.realization(realization).expect("a built-in part");
    let dynamics = registry
        .dynamics("hamilton-jacobi")
        .expect("a built-in part");
    let dynamics = dynamics.build(&none.clone().with("order", m));
    Method::compose(
        system,
        realization.build(system, &none).expect("it fits"),
        dynamics.expect("an even order"),
    )
    .expect("a method")
}

/// y_1 less its start, y_0 + 2 Σ tᵏ Y_k(x_1).
fn start_error(method: &Method, parameters: &[f64], t: f64) -> f64 {
    let mut stepper = method.stepper(1, parameters, 1.0, t);
    let mut x = INITIAL.to_vec();
    let mut solutions = Vec::new();
    let mut step = |x: &[f64]| {
        let (mut increment, mut outcome) = ([0.0; 3], [Ok(())]);
        stepper.increment(x, &[0.0; 3], &mut increment, &mut outcome);
        assert_eq!(outcome, [Ok(())], "t = {t}");
        solutions.push(stepper.solution(0).expect("a bisection"));
        increment
    };
    let increment = step(&x);
    x.iter_mut().zip(increment).for_each(|(x, i)| *x += i);
    step(&x);
    let kernel = method
        .newton()
        .expect("code")
        .start()
        .expect("a short series");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, parameters, &[1.0], &[t]);
    let mut odd = [0.0; 3];
    kernel.evaluate(&mut workspace, &x, &mut odd);
    let start: Vec<f64> = solutions[0]
        .iter()
        .zip(odd)
        .map(|(y, odd)| y + odd)
        .collect();
    distance(&start, &solutions[1])
}

/// The terms up to t⁷ leave one of t⁹, whatever the order of Ŝ: the series is that of the method, not of
/// the flow.
#[test]
fn a_start_is_off_by_the_first_term_that_its_series_leaves_out() {
    let system = library("rigid-body").system;
    let parameters = system.parameter_values();
    for m in [2, 4, 6] {
        let method = method(&system, "so3-exponential", m);
        let [far, near] = [0.2, 0.1].map(|t| start_error(&method, &parameters, t));
        let slope = libm::log2(far / near);
        println!("m = {m}: off by {far:.1e} and {near:.1e}, order {slope:.2}");
        // The next term is smaller by a part of (0.2)² times the squared rate of turning, about 4.
        assert!((slope - 9.0).abs() <= 0.5, "m = {m}: {slope}");
    }
}

/// A start off by δ leaves C δ² after one correction: at small steps nothing, at larger ones what one or two more take
/// away. Extrapolation, which foresees nothing at large steps, takes three times as many on the species at t = 0.2.
#[test]
fn a_step_of_a_short_series_takes_few_evaluations() {
    let body = ("rigid-body", "so3-exponential", 8, INITIAL);
    let species = |m| {
        let initial = [1.0, 1.9, 0.5];
        ("lotka-volterra-periodic", "log-canonical", m, initial)
    };
    for ((name, realization, m, initial), steps) in [
        (body, &[(0.1, 1.4), (0.27, 2.2), (0.42, 3.8)][..]),
        (species(2), &[(0.05, 2.1), (0.2, 3.3)]),
        (
            species(4),
            &[(0.02, 1.1), (0.05, 2.1), (0.1, 2.8), (0.2, 3.2)],
        ),
    ] {
        let system = library(name).system;
        let method = method(&system, realization, m);
        for &(t, most) in steps {
            let mut walk = Walk::new(&method, &system.parameter_values(), 1.0, t, &initial);
            for _ in 0..1000 {
                walk.step().expect("inside the chart");
            }
            let evaluations = walk.statistics().evaluations_per_step();
            println!("{name}, m = {m}, t = {t}: {evaluations:.2} evaluations a step");
            assert!(
                evaluations <= most,
                "{name}, m = {m}, t = {t}: {evaluations}"
            );
        }
    }
}

/// The heavy top's series is longer than what it saves.
#[test]
fn a_long_series_is_no_start() {
    let system = library("heavy-top").system;
    let method = method(&system, "lie-poisson", 4);
    assert!(method.newton().expect("code").start().is_none());
}
