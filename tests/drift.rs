//! The Casimir of the rigid body over 10⁶ steps, as the maximum over every step, and what keeps it.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::diagnostics::measure_drift;
use leafwise::core::{Observer, Registry, StepMap, Walk};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::{library, method};

const STEPS: usize = 1_000_000;

/// max_k |C(x_k) − C(x_0)| / C(x_0) for C = |x|², with what the state holds beyond a double: the
/// sum of squares itself is rounded three times, which alone is 3e-16 relative.
fn drift(n: usize, m: usize, epsilon: f64, h: f64) -> f64 {
    let body = library("rigid-body");
    let method = method(&body.system, n, m);
    let parameters = body.system.parameter_values();
    let mut walk = Walk::new(&method, &parameters, epsilon, h, &body.initial);
    let casimir = |x: &[f64], low: &[f64]| -> f64 {
        x.iter()
            .zip(low)
            .map(|(x, low)| x * x + 2.0 * x * low)
            .sum()
    };
    let start = casimir(&body.initial, &[0.0; 3]);
    let mut worst = 0.0_f64;
    for _ in 0..STEPS {
        walk.step().expect("a step");
        let now = casimir(walk.state(), walk.compensation());
        worst = worst.max((now - start).abs() / start);
    }
    let work = walk.statistics().evaluations_per_step();
    println!("n = {n} m = {m} eps = {epsilon} h = {h}: drift {worst:.1e}, {work:.2} evaluations");
    worst
}

/// Every truncation conserves |x|² exactly, so that all drift is round-off of the solve and of the
/// update. The update is compensated; what remains is a random walk of 10⁶ increments, each with
/// an error of 2 u times its relative size t|ẋ|/|x| < 1/3: 10³ · 2 · 1.1e-16 / 3 = 7e-14.
#[test]
fn the_paper_s_method_keeps_the_casimir_within_1e_13_over_a_million_steps() {
    let drift = drift(6, 2, 0.1, 2.0);
    assert!(drift <= 1e-13, "{drift:e}");
}

/// As above; half the time step and more operations an increment.
#[test]
fn a_method_of_order_8_keeps_the_casimir_within_1e_13_over_a_million_steps() {
    let drift = drift(10, 8, 0.1, 1.0);
    assert!(drift <= 1e-13, "{drift:e}");
}

/// What the state holds beyond a double enters the next step: Φ(x + low) − (x + low) from the pair
/// (x, low) is that of the sum. The pair is taken with a low part that shows, 2⁻¹⁰ of x; both
/// increments are solutions of one equation, within a few dozen roundings of the state.
#[test]
fn the_compensation_is_part_of_the_state() {
    let body = library("rigid-body");
    let method = method(&body.system, 6, 4);
    let parameters = body.system.parameter_values();
    let low: Vec<f64> = body.initial.iter().map(|x| x / 1024.0).collect();
    let sum: Vec<f64> = body.initial.iter().zip(&low).map(|(x, l)| x + l).collect();
    let increment = |x: &[f64], low: &[f64]| -> Vec<f64> {
        let (mut increment, mut outcome) = (vec![0.0; 3], [Ok(())]);
        let mut stepper = method.stepper(1, &parameters, 0.1, 2.0);
        stepper.increment(x, low, &mut increment, &mut outcome);
        assert_eq!(outcome, [Ok(())]);
        increment
    };
    let (pair, whole) = (increment(&body.initial, &low), increment(&sum, &[0.0; 3]));
    let error = distance(&pair, &whole) / largest(&sum);
    println!("the pair and the sum differ by {error:.1e} of the state");
    assert!(error <= 50.0 * UNIT_ROUNDOFF, "{pair:?} {whole:?}");
    let without = increment(&body.initial, &[0.0; 3]);
    assert!(
        distance(&without, &whole) > 1e-4,
        "the low part matters here"
    );
}

/// Two species of the paper's Lotka–Volterra system die out like exp(−14 t), and the Casimir
/// x1 x3/x2 feels the relative error of each: over 800 steps that of the truncation at n = 8, some
/// (0.14)⁹/9! = 6e-14 a step. With a Jacobian from before they fell their error was absolute, the
/// Casimir lost after 150 steps and a species negative.
#[test]
fn dying_species_keep_their_relative_accuracy() {
    let species = library("lotka-volterra");
    let method = method(&species.system, 8, 2);
    let mut walk = Walk::new(&method, &[], 0.01, 2.0, &[1.0, 3.0, 3.0]);
    while walk.state()[0] > 1e-100 {
        walk.step().expect("a step");
        let x = walk.state();
        assert!(x.iter().all(|x| *x > 0.0), "{x:?}");
        let drift = (x[0] * x[2] / x[1] - 1.0).abs();
        assert!(drift <= 1e-9, "step {}: {drift:e}", walk.steps());
    }
}

/// An observable without a value at one step: its deviation is none that is small, whatever follows.
#[test]
fn a_value_that_is_lost_at_one_step_is_not_forgotten() {
    let problem = library("rigid-body");
    let values = problem.system.parameter_values();
    let registry = Registry::with_builtin();
    let method = registry.automatic(&problem.system, 2).expect("a method");
    for lost in 0..20 {
        let mut walk = Walk::new(&method, &values, 1.0, 0.01, &problem.initial);
        let mut evaluated = 0;
        let lost_at = Observer::new(1, move |_, values| {
            values[0] = if evaluated == lost { f64::NAN } else { 1.0 };
            evaluated += 1;
        });
        let drifts = measure_drift(&mut walk, lost_at, 10).expect("steps");
        assert_eq!(drifts[0].largest.is_nan(), lost <= 10, "lost at {lost}");
    }
}
