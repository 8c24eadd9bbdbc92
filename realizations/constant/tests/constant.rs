//! The realization of a constant tensor is exact, and with S_1 its step is the implicit midpoint
//! rule.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers are shown with --nocapture"
)]

use std::sync::Arc;

use leafwise_constant::Constant;
use leafwise_core::{BuildError, PoissonSystem, RealizationData};
use leafwise_realization_claims::lattice::{Chain, by_templates_and_written_out};
use leafwise_realization_claims::realizations::{dual_pair_error, inversion_and_section_error};
use leafwise_realization_claims::steps::{
    implicit_midpoint, is_even_order, measured_order, method, run, structure_error,
};
use leafwise_realization_claims::systems::{from_formulas, library};
use leafwise_realization_claims::{UNIT_ROUNDOFF, distance, largest};
use proptest::collection::vec;
use proptest::prelude::*;

/// A degenerate tensor of rank 4 in five variables with a parameter, the Hamiltonian a polynomial;
/// Π w = 0 for w = (0, a, −a² − 2, 0, −a), so that w·x is a Casimir.
fn degenerate() -> PoissonSystem {
    from_formulas(
        &["x1", "x2", "x3", "x4", "x5"],
        &[("a", 0.7)],
        &[
            ("x1", "x2", "1"),
            ("x1", "x4", "2"),
            ("x2", "x4", "a^2"),
            ("x3", "x4", "a"),
            ("x5", "x1", "-1"),
            ("x4", "x5", "2 - a^2 + a^2"),
        ],
        "(x1^2 + x2^2 + x3^2 + x4^2 + x5^2)/2 + x1*x2^2/5 + x4^4/20 - x3*x5/3",
        &["a*x2 - (a^2 + 2)*x3 - a*x5"],
    )
}

fn realization(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(Constant::realize(system).expect("a constant tensor"))
}

proptest! {
    #[test]
    fn the_maps_are_a_dual_pair(
        x in vec(-2.0..2.0_f64, 5),
        p in vec(-3.0..3.0_f64, 5),
        epsilon in 0.01..2.0_f64,
    ) {
        let system = degenerate();
        let realization = realization(&system);
        let error = dual_pair_error(&system, &realization, epsilon, &x, &p).expect("maps");
        prop_assert!(error <= 1e-13, "{error:e}");
        let error = inversion_and_section_error(&system, realization.as_ref(), epsilon, &x, &p);
        prop_assert!(error.expect("maps") <= 4.0 * UNIT_ROUNDOFF);
    }

    #[test]
    fn steps_are_poisson_and_keep_the_casimir(x in vec(0.2..1.5_f64, 5), half_order in 1..4_usize) {
        let system = degenerate();
        let map = method(&system, &realization(&system), 2 * half_order);
        let error = structure_error(&system, &map, 0.1, &x).expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{error:?}");
    }
}

#[test]
fn the_first_coefficient_gives_the_implicit_midpoint_rule() {
    let system = degenerate();
    let map = method(&system, &realization(&system), 2);
    let x = [0.5, -0.3, 0.8, 1.1, -0.6];
    for h in [0.01, 0.05, 0.2] {
        let expected = implicit_midpoint(&system, h, &x);
        let found = run(&system, &map, h, 1, &x).expect("a step");
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
    let realization = realization(&system);
    for (m, steps) in [
        (2, [16, 32, 64, 128]),
        (4, [16, 32, 64, 128]),
        (6, [8, 16, 32, 64]),
        (8, [6, 8, 12, 16]),
    ] {
        let map = method(&system, &realization, m);
        let x = [0.5, -0.3, 0.8, 1.1, -0.6];
        let slope = measured_order(&system, &map, &x, 1.0, &steps).expect("points");
        println!("constant, m = {m}: {slope:?}");
        assert!(is_even_order(slope, m), "m = {m}: {slope:?}");
    }
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
    let system = from_formulas(&["x", "y"], &[], &[("x", "y", entry)], "x^2 + y^4", &[]);
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
