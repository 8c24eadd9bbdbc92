//! The realization error ε Π(α̂) − {α̂, α̂}_ω at the paper's points has the slopes theory says.
//!
//! On so(3)* the paper reads 4.9 and 10.99 off its plots for n = 4 and n = 10 and compares with
//! n + 1 = 5 and 11. The slopes are n + 2 = 6 and 12: for a linear tensor
//! α = Σ_k (B_k/k!) (εA)ᵏ x with the Bernoulli numbers B_k, and B_{n+1} = 0 for even n ≥ 2, so that
//! the first neglected term has order ε^{n+2}. (The even orders are therefore exact one order
//! further than the paper's bound, which still holds; numerical derivatives and a window that
//! reaches out of the asymptotic regime hid it.) On Lotka–Volterra no order vanishes: n + 1.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::Registry;
use leafwise::core::diagnostics::RealizationInstrument;
use leafwise::reproduce::{ErrorCurve, RealizationPoint};
use leafwise_tests::numbers::UNIT_ROUNDOFF;
use leafwise_tests::orders::{MeasuredOrder, measure};
use leafwise_tests::{library, realization};

/// Roundings that end up in one component of the error: its two brackets are sums of products of
/// derivatives, each a few hundred operations deep at n = 10.
const OPERATIONS: f64 = 1e3;

/// Errors on a grid of six ε an octave from `largest` downwards.
fn errors(point: &RealizationPoint, largest: f64, octaves: i32) -> ErrorCurve {
    let epsilons: Vec<f64> = (0..=6 * octaves)
        .map(|k| largest * libm::exp2(-f64::from(k) / 6.0))
        .collect();
    let curve = point
        .errors(&Registry::with_builtin(), &epsilons)
        .expect("a realization");
    assert_eq!(curve.points.len(), epsilons.len(), "all inside the chart");
    curve
}

/// `gap` is the order by which the next term of the error is smaller.
fn slope(name: &str, n: i64, series: &ErrorCurve, gap: f64) -> MeasuredOrder {
    let measured = measure(&series.points, series.round_off, gap).expect("points above round-off");
    println!("{name} n = {n}: slope {measured}");
    assert!(
        measured.slope.points >= 5,
        "{name} n = {n}: {:?}",
        series.points
    );
    measured
}

#[test]
fn on_so3_the_slope_of_even_n_is_n_plus_2() {
    // The series' radius is 2π/‖p‖ = 1.68; in the window the next term is below a few per cent.
    for (n, largest, octaves) in [(2, 0.08, 3), (4, 0.16, 2), (10, 0.4, 1)] {
        let series = errors(&RealizationPoint::on_so3(n), largest, octaves);
        let measured = slope("so(3)*", n, &series, 2.0);
        assert!(
            measured.is(n as f64 + 2.0, 1.0),
            "{measured}: {:?}",
            series.points
        );
    }
}

#[test]
fn on_lotka_volterra_the_slope_is_n_plus_1() {
    // The exponents ½ Σ_j a_ij x_j p_j of the closed form reach 15: ε·15 is the small quantity.
    for (n, largest, octaves) in [(2, 0.002, 3), (4, 0.004, 2), (8, 0.01, 1)] {
        let point = RealizationPoint {
            system: "lotka-volterra",
            order: n,
            x: vec![1.0, 3.0, 3.0],
            p: vec![1.0, 2.0, 3.0],
        };
        let series = errors(&point, largest, octaves);
        let measured = slope("Lotka-Volterra", n, &series, 1.0);
        assert!(
            measured.is(n as f64 + 1.0, 1.0),
            "{measured}: {:?}",
            series.points
        );
    }
}

#[test]
fn on_the_magnetic_bracket_the_slope_of_n_2_is_3() {
    let series = errors(&RealizationPoint::on_magnetic(2), 0.02, 3);
    let measured = slope("magnetic", 2, &series, 1.0);
    assert!(measured.is(3.0, 1.0), "{measured}: {:?}", series.points);
}

/// The series ends: α̂ of order 3 is α. What is left is the round-off of brackets of this size.
#[test]
fn on_the_magnetic_bracket_n_3_is_exact() {
    let system = library("magnetic").system;
    let part = realization(&system, 3);
    let mut instrument =
        RealizationInstrument::new(&system, &part, &[]).expect("a realization with code");
    let at = RealizationPoint::on_magnetic(3);
    for epsilon in [0.01, 0.1, 1.0, 3.0] {
        let error = instrument
            .measure(epsilon, &at.x, &at.p)
            .expect("in the chart");
        let bound = OPERATIONS * UNIT_ROUNDOFF * error.scale.max(1.0);
        println!(
            "magnetic n = 3 eps = {epsilon}: {:.1e} of {:.1e}",
            error.source, error.scale
        );
        assert!(
            error.source <= bound && error.target <= bound,
            "eps = {epsilon}: {error:?}"
        );
        assert!(error.dual_pair <= bound, "eps = {epsilon}: {error:?}");
    }
}
