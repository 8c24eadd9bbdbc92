//! Orders in the time step t = εh, measured as global errors over a fixed time.
//!
//! K-HJ maps are self-adjoint, so that their errors expand in even powers of t: orders are even,
//! and the next term is smaller by t².

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::collections::BTreeMap;

use leafwise::core::PoissonSystem;
use leafwise_tests::methods::run;
use leafwise_tests::numbers::{distance, largest};
use leafwise_tests::orders::{MeasuredOrder, measure};
use leafwise_tests::{Problem, gauss, library, method};

const TIME: f64 = 1.0;

/// Steps over [`TIME`]; the sequence of coarsest steps at which the series converge.
const STEPS: [usize; 9] = [6, 8, 11, 16, 22, 32, 45, 64, 90];

/// Round-off of a relative error: both ends of a comparison are rounded to doubles, and compensated
/// steps add less than an ulp in all.
const ROUND_OFF: f64 = 2.0 * f64::EPSILON;

fn reference(problem: &Problem) -> Vec<f64> {
    let (fine, finer) = [200, 300]
        .map(|steps| gauss::flow(&problem.system, &problem.initial, TIME, steps))
        .into();
    let spread = distance(&fine, &finer) / largest(&finer);
    assert!(
        spread < 20.0 * f64::EPSILON,
        "the oracle agrees with itself: {spread:e}"
    );
    finer
}

/// Errors relative to the state for ε = `epsilon` and h = t/ε.
fn errors(
    problem: &Problem,
    exact: &[f64],
    n: usize,
    m: usize,
    steps: &[usize],
) -> Vec<(f64, f64)> {
    let method = method(&problem.system, n, m);
    let epsilon = 0.5;
    steps
        .iter()
        .map(|&steps| {
            let t = TIME / steps as f64;
            let sizes = (epsilon, t / epsilon);
            let end = run(&problem.system, &method, sizes, steps, &problem.initial)
                .expect("every step converges");
            (t, distance(&end, exact) / largest(exact))
        })
        .collect()
}

fn order(problem: &Problem, exact: &[f64], n: usize, m: usize, coarsest: usize) -> MeasuredOrder {
    let points = errors(problem, exact, n, m, &STEPS[coarsest..]);
    measure(&points, ROUND_OFF, 2.0)
        .unwrap_or_else(|| panic!("n = {n}, m = {m}: too few points above round-off: {points:?}"))
}

/// The measured order of every pair, printed beside Theorem 2's bound min(n, m).
fn table(name: &str, problem: &Problem, coarsest: usize, expected: fn(usize, usize) -> usize) {
    let exact = reference(problem);
    println!("{name}: measured order (Theorem 2: at least min(n, m))");
    let mut rows = BTreeMap::new();
    for n in 1..=7 {
        let mut line = format!("  n = {n}:");
        for m in [2, 4, 6, 8] {
            let measured = order(problem, &exact, n, m, coarsest);
            line += &format!("   m = {m}: {measured} ({})", n.min(m));
            rows.insert((n, m), measured);
        }
        println!("{line}");
    }
    for ((n, m), measured) in rows {
        let expected = expected(n, m);
        assert!(expected >= n.min(m), "at least Theorem 2's bound");
        assert!(
            measured.is(expected as f64, 2.0),
            "n = {n}, m = {m}: {measured}, not {expected}"
        );
    }
}

#[test]
fn over_lotka_volterra_the_order_is_min_m_and_2_ceil_half_n() {
    let problem = library("lotka-volterra-periodic");
    table("Lotka-Volterra", &problem, 0, |n, m| {
        m.min(2 * n.div_ceil(2))
    });
}

/// Odd Bernoulli numbers vanish: an even n is as good as n + 1 and one order better than its name.
#[test]
fn over_so3_the_order_is_min_m_and_2_floor_half_n_plus_2() {
    let problem = library("rigid-body");
    table("so(3)*", &problem, 1, |n, m| m.min(2 * (n / 2) + 2));
}

fn dynamic_orders(name: &str, problem: &Problem, n: usize, coarsest: usize) {
    let exact = reference(problem);
    for m in [2, 4, 6, 8] {
        let measured = order(problem, &exact, n, m, coarsest);
        println!("{name} n = {n} m = {m}: {measured}");
        assert!(measured.is(m as f64, 2.0), "{name} m = {m}: {measured}");
    }
}

#[test]
fn the_dynamic_order_is_m_on_the_rigid_body() {
    dynamic_orders("rigid body", &library("rigid-body"), 14, 1);
}

#[test]
fn the_dynamic_order_is_m_on_the_periodic_lotka_volterra() {
    dynamic_orders("Lotka-Volterra", &library("lotka-volterra-periodic"), 10, 0);
}

/// With linear H the generating function hH is exact: S_3, S_5, … vanish and m does not matter.
#[test]
fn a_linear_hamiltonian_leaves_only_the_geometric_error() {
    let problem = library("lotka-volterra");
    let system: &PoissonSystem = &problem.system;
    let [low, high] = [2, 8].map(|m| {
        let method = method(system, 8, m);
        run(system, &method, (0.01, 2.0), 20, &problem.initial).expect("every step converges")
    });
    assert_eq!(low, high, "m = 2 and m = 8 are one map");
}
