//! The realization of a constant tensor is exact, and with S_1 its step is the implicit midpoint
//! rule.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers are shown with --nocapture"
)]

use std::sync::Arc;

use leafwise_constant::Constant;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};
use leafwise_tests::gauss::implicit_midpoint;
use leafwise_tests::lattice::{Chain, by_templates_and_written_out};
use leafwise_tests::library;
use leafwise_tests::methods::{hamilton_jacobi, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::realizations::{
    assert_dual_pair, assert_orders, assert_poisson_steps, dual_pair_error,
};
use leafwise_tests::systems::from_formulas;

/// A degenerate tensor of rank 4 in five variables with a parameter, the Hamiltonian a polynomial;
/// Π w = 0 for w = (0, a, −a² − 2, 0, −a), so that w·x is a Casimir.
fn degenerate() -> PoissonSystem {
    from_formulas(
        &["x1", "x2", "x3", "x4", "x5"],
        &[("a", 0.7)],
        &[
            ("x1,x2", "1"),
            ("x1,x4", "2"),
            ("x2,x4", "a^2"),
            ("x3,x4", "a"),
            ("x5,x1", "-1"),
            ("x4,x5", "2 - a^2 + a^2"),
        ],
        "(x1^2 + x2^2 + x3^2 + x4^2 + x5^2)/2 + x1*x2^2/5 + x4^4/20 - x3*x5/3",
        &[("kernel", "a*x2 - (a^2 + 2)*x3 - a*x5")],
    )
}

fn realization(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(Constant::realize(system).expect("a constant tensor"))
}

#[test]
fn the_maps_are_a_dual_pair() {
    let system = degenerate();
    let domain = (-2.0..2.0, -3.0..3.0, 0.01..2.0);
    assert_dual_pair(&system, &realization(&system), domain, 4.0);
}

#[test]
fn steps_are_poisson_and_keep_the_casimir() {
    let system = degenerate();
    assert_poisson_steps(&system, &realization(&system), 0.2..1.5, 0.1);
}

#[test]
fn the_first_coefficient_gives_the_implicit_midpoint_rule() {
    let system = degenerate();
    let map = hamilton_jacobi(&system, &realization(&system), 2);
    let x = [0.5, -0.3, 0.8, 1.1, -0.6];
    for h in [0.01, 0.05, 0.2] {
        let expected = implicit_midpoint(&system, h, &x);
        let found = run(&system, &map, (1.0, h), 1, &x).expect("a step");
        let bound = 16.0 * UNIT_ROUNDOFF * largest(expected.clone());
        assert!(
            distance(&found, &expected) <= bound,
            "{found:?} {expected:?}"
        );
    }
}

#[test]
fn measured_orders_are_those_declared() {
    let system = degenerate();
    let orders = [
        (2, [16, 32, 64, 128]),
        (4, [16, 32, 64, 128]),
        (6, [8, 16, 32, 64]),
        (8, [6, 8, 12, 16]),
    ];
    let start = (&[0.5, -0.3, 0.8, 1.1, -0.6][..], 1.0);
    assert_orders(&system, &realization(&system), start, &orders);
}

#[test]
fn an_entry_with_variables_is_named() {
    let system = library("rigid-body").system;
    let refusal = Constant::realize(&system).expect_err("a linear tensor");
    let BuildError::DoesNotFit { part, reason } = refusal else {
        panic!("{refusal:?}");
    };
    assert_eq!(part, "constant");
    assert!(reason.contains("{x1, x2}"), "{reason}");
}

/// (x + 1)² − x² − 2x is 1: the normal form decides, not the way it is written.
#[test]
fn constancy_is_decided_by_the_normal_form() {
    let entry = "(x + 1)^2 - x^2 - 2*x";
    let system = from_formulas(&["x", "y"], &[], &[("x,y", entry)], "x^2 + y^4", &[]);
    let realization = realization(&system);
    let error = dual_pair_error(&system, &realization, 0.3, &[0.4, -2.0], &[1.5, 0.2]);
    assert!(error.expect("maps") <= 1e-13);
}

/// Both solve the same equation to round-off; after 20 steps they differ by that many solves of a
/// few units in the last place.
#[test]
fn a_lattice_steps_as_its_written_out_form() {
    for periodic in [true, false] {
        let hamiltonian = "sum(i, x[i]^2/2 + x[i]^4/20 + x[i]*x[i+1]/5)";
        let chain = Chain::new((24, periodic), ("x[i],x[i+1]", "1/2"), hamiltonian);
        let initial: Vec<f64> = (0..24).map(|i| libm::sin(1.7 * f64::from(i))).collect();
        let (templates, written_out) =
            by_templates_and_written_out(&chain, realization, 2, (0.05, 20), &initial);
        let bound = 20.0 * 16.0 * UNIT_ROUNDOFF * largest(written_out.clone());
        assert!(distance(&templates, &written_out) <= bound);
    }
}
