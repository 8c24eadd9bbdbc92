//! The realization of a log-canonical tensor is exact, and not Karasev's.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers are shown with --nocapture"
)]

use std::sync::Arc;

use leafwise_core::{BuildError, Ends, PoissonSystem, RealizationData};
use leafwise_expression::{Arithmetic, Rational};
use leafwise_hamilton_jacobi::generating_function;
use leafwise_log_canonical::LogCanonical;
use leafwise_tests::lattice::{Chain, by_templates_and_written_out};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::realizations::{assert_dual_pair, assert_orders, assert_poisson_steps, ends};
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{Problem, library};
use proptest::collection::vec;
use proptest::prelude::*;

fn realization(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(LogCanonical::realize(system).expect("a log-canonical tensor"))
}

/// Four species with all six brackets and a coefficient that is a function of the parameters.
fn four_species() -> PoissonSystem {
    from_formulas(
        &["x1", "x2", "x3", "x4"],
        &[("a", 1.3)],
        &[
            ("x1,x2", "x1*x2"),
            ("x1,x3", "-a*x1*x3"),
            ("x4,x1", "exp(-a)*x1*x4"),
            ("x2,x3", "x2*x3^2/x3/2"),
            ("x2,x4", "x4*x2*(a^2 - 1)"),
            ("x3,x4", "x3*x4/a"),
        ],
        "x1 + x2 + x3*x4/2 + x1*x4 + ln(x2)",
        &[],
    )
}

#[test]
fn the_maps_are_a_dual_pair() {
    let system = four_species();
    let domain = (-2.0..2.0, -2.0..2.0, 0.01..1.0);
    assert_dual_pair(&system, &realization(&system), domain, 16.0);
}

#[test]
fn steps_are_poisson_and_keep_the_casimir() {
    let Problem { system, .. } = library("lotka-volterra-periodic");
    assert_poisson_steps(&system, &realization(&system), 0.5..2.0, 0.05);
}

proptest! {
    #[test]
    fn the_ends_are_formed_without_cancellation(
        x in vec(0.1..2.0_f64, 4),
        p in vec(-1.0..1.0_f64, 4),
        size in 1..40_i32,
    ) {
        let system = four_species();
        let a: f64 = 1.3;
        let rates = [
            [0.0, 1.0, -a, -libm::exp(-a)],
            [-1.0, 0.0, 0.5, a * a - 1.0],
            [a, -0.5, 0.0, 1.0 / a],
            [libm::exp(-a), 1.0 - a * a, -1.0 / a, 0.0],
        ];
        let epsilon = libm::exp2(-f64::from(size));
        let point = [x.clone(), p.clone()].concat();
        let found = ends(&system, realization(&system).as_ref(), epsilon, &point);
        let found = found.expect("maps");
        let found = Ends::of(&found);
        for i in 0..4 {
            let terms = |abs: bool| -> f64 {
                let terms = (0..4).map(|j| rates[i][j] * x[j] * p[j]);
                terms.map(|t| if abs { t.abs() } else { t }).sum()
            };
            let u = 0.5 * epsilon * terms(false);
            // Round-off of the sum u relative to its summands, and a few roundings of the value.
            let bound = 16.0 * UNIT_ROUNDOFF * x[i] * epsilon * terms(true) * libm::exp(u.abs());
            prop_assert!((found.offset[i] - x[i] * libm::expm1(u)).abs() <= bound);
            prop_assert!((found.increment[i] + 2.0 * x[i] * libm::sinh(u)).abs() <= bound);
        }
    }
}

#[test]
fn measured_orders_are_those_declared() {
    let Problem {
        system, initial, ..
    } = library("lotka-volterra-periodic");
    let orders = [
        (2, [32, 64, 128, 256]),
        (4, [32, 64, 128, 256]),
        (6, [16, 24, 32, 64]),
        (8, [12, 14, 16, 20]),
    ];
    assert_orders(&system, &realization(&system), (&initial, 1.0), &orders);
}

#[test]
fn an_entry_of_another_shape_is_named() {
    let system = from_formulas(
        &["x", "y", "z"],
        &[],
        &[("x,y", "x*y"), ("y,z", "y*z + y"), ("x,z", "x*z")],
        "x + y + z",
        &[],
    );
    let refusal = LogCanonical::realize(&system).expect_err("not log-canonical");
    let BuildError::DoesNotFit { part, reason } = refusal else {
        panic!("{refusal:?}");
    };
    assert_eq!(part, "log-canonical");
    assert!(reason.contains("{y, z}"), "{reason}");
}

/// Both solve the same equation to round-off; after 20 steps they differ by that many solves of a
/// few units in the last place.
#[test]
fn a_lattice_steps_as_its_written_out_form() {
    for periodic in [true, false] {
        let hamiltonian = "sum(i, x[i] + x[i]*x[i+1]/5)";
        let chain = Chain::new((24, periodic), ("x[i],x[i+1]", "x[i]*x[i+1]"), hamiltonian);
        let initial: Vec<f64> = (0..24)
            .map(|i| 1.0 + 0.3 * libm::sin(1.7 * f64::from(i)))
            .collect();
        let (templates, written_out) =
            by_templates_and_written_out(&chain, realization, 2, (0.05, 20), &initial);
        let bound = 20.0 * 16.0 * UNIT_ROUNDOFF * largest(written_out.clone());
        assert!(distance(&templates, &written_out) <= bound);
    }
}

/// For H = x + y the Karasev chart has S = hH (the paper's Lotka–Volterra example); here
/// S_3 = [h²] H(α(x, h dH))/3 = (x ½y·½y + y ½x·½x)/6 = (x y² + x² y)/24.
#[test]
fn the_third_coefficient_is_that_of_this_chart() {
    let system = from_formulas(&["x", "y"], &[], &[("x,y", "x*y")], "x + y", &[]);
    let realization = realization(&system);
    let series = realization.abilities().series.expect("a series");
    let generating = generating_function(&system, &series, 4).expect("in the algebra");
    let mut ring = generating.ring.clone();
    let (x, y) = (ring.variable(0), ring.variable(1));
    let (xy, sum) = (ring.multiply(&x, &y), ring.add(&x, &y));
    let product = ring.multiply(&xy, &sum);
    let expected = ring.scale(&Rational::new(1, 24), &product);
    assert_eq!(generating.coefficients[1], expected);
}
