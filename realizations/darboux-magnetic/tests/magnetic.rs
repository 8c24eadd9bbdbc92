//! The realization of a magnetic bracket is exact, and with S_1 its step is the implicit midpoint
//! rule in Darboux coordinates.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers are shown with --nocapture"
)]

use std::sync::Arc;

use leafwise_core::{BuildError, PartParameters, PoissonSystem, RealizationData, Registry};
use leafwise_darboux_magnetic::DarbouxMagnetic;
use leafwise_tests::gauss::implicit_midpoint;
use leafwise_tests::library;
use leafwise_tests::methods::{hamilton_jacobi, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::realizations::{
    assert_dual_pair, assert_orders, assert_poisson_steps, source_and_target,
};
use leafwise_tests::systems::from_formulas;
use proptest::collection::vec;
use proptest::prelude::*;

/// The paper's potential for the field x² dx∧dy + y dy∧dz + z dx∧dz.
const POTENTIAL: &str = "0; x^3/3; y^2/2 + x*z";

/// Systems with a potential each: the paper's, one in another gauge, and one in the plane with
/// variables in another order, positive sign, parameters and functions that are not polynomials.
fn systems() -> [(PoissonSystem, &'static str); 3] {
    let paper = library("magnetic").system;
    let gauge = "2*x*y; x^3/3 + x^2 + z^2; y^2/2 + x*z + 2*y*z";
    let plane = from_formulas(
        &["px", "x", "y", "py"],
        &[("b", 0.7), ("k", 1.3)],
        &[
            ("x,px", "1"),
            ("y,py", "1"),
            ("px,py", "-b - k*cos(k*x) - x/sqrt(1 + x^2 + y^2)"),
        ],
        "(px^2 + py^2)/2 + x^2/2 + y^4/4 + x*y/5",
        &[],
    );
    [
        (paper.clone(), POTENTIAL),
        (paper, gauge),
        (plane, "0; b*x + sin(k*x) + sqrt(1 + x^2 + y^2)"),
    ]
}

fn realization(system: &PoissonSystem, potential: &str) -> Arc<dyn RealizationData> {
    Arc::new(DarbouxMagnetic::realize(system, potential).expect("a magnetic bracket"))
}

#[test]
fn the_maps_are_a_dual_pair() {
    for (system, potential) in systems() {
        let domain = (-2.0..2.0, -2.0..2.0, 0.01..1.0);
        assert_dual_pair(&system, &realization(&system, potential), domain, 16.0);
    }
}

#[test]
fn steps_are_poisson() {
    for (system, potential) in systems() {
        assert_poisson_steps(&system, &realization(&system, potential), 0.2..1.5, 0.05);
    }
}

proptest! {
    /// The formula of the definition, evaluated by hand for the paper's potential.
    #[test]
    fn the_maps_are_those_of_darboux_coordinates(
        x in vec(-2.0..2.0_f64, 6),
        p in vec(-2.0..2.0_f64, 6),
    ) {
        let potential = |x: &[f64]| {
            [0.0, x[0] * x[0] * x[0] / 3.0, x[1] * x[1] / 2.0 + x[0] * x[2]]
        };
        let (system, text) = systems()[0].clone();
        let realization = realization(&system, text);
        let ends = source_and_target(&system, realization.as_ref(), 1.0, &x, &p);
        let (found, _) = ends.expect("maps");
        // ξ = DΦ^{−T}(a, b): ξ_x = a + A′ᵀ b, ξ_P = b; Π′ = −1 on (x, P).
        let pulled = [
            p[0] + x[0] * x[0] * p[4] + x[2] * p[5],
            p[1] + x[1] * p[5],
            p[2] + x[0] * p[5],
        ];
        let here = potential(&x);
        let position: Vec<f64> = (0..3).map(|i| x[i] + 0.5 * p[3 + i]).collect();
        let there = potential(&position);
        let mut expected = position.clone();
        expected.extend((0..3).map(|i| x[3 + i] - here[i] - 0.5 * pulled[i] + there[i]));
        // Some ten operations on numbers below 10.
        let bound = 64.0 * UNIT_ROUNDOFF * 10.0;
        prop_assert!(distance(&found, &expected) <= bound, "{found:?} {expected:?}");
    }
}

#[test]
fn the_first_coefficient_gives_the_midpoint_rule_in_darboux_coordinates() {
    let (system, potential) = systems()[0].clone();
    let darboux = from_formulas(
        &["x", "y", "z", "px", "py", "pz"],
        &[],
        &[("x,px", "-1"), ("y,py", "-1"), ("z,pz", "-1")],
        "(px^2 + (py + x^3/3)^2 + (pz + y^2/2 + x*z)^2 + x^2 + y^2 + z^2)/2",
        &[],
    );
    let a = |x: &[f64]| {
        [
            0.0,
            0.0,
            0.0,
            0.0,
            x[0] * x[0] * x[0] / 3.0,
            x[1] * x[1] / 2.0 + x[0] * x[2],
        ]
    };
    let map = hamilton_jacobi(&system, &realization(&system, potential), 2);
    let x = [1.0, 0.5, -0.5, 0.3, 0.2, 0.4];
    for h in [0.01, 0.05, 0.2] {
        let start: Vec<f64> = x.iter().zip(a(&x)).map(|(x, a)| x - a).collect();
        let end = implicit_midpoint(&darboux, h, &start);
        let expected: Vec<f64> = end.iter().zip(a(&end)).map(|(x, a)| x + a).collect();
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
    let orders = [
        (2, [16, 32, 64, 128]),
        (4, [16, 24, 32, 64]),
        (6, [12, 16, 20, 24]),
    ];
    for (system, potential) in systems() {
        let x = [0.8, 0.5, -0.5, 0.3, 0.2, 0.4];
        let start = (&x[..system.dimension()], 1.0);
        assert_orders(&system, &realization(&system, potential), start, &orders);
    }
}

#[test]
fn what_does_not_fit_is_named() {
    let magnetic = library("magnetic").system;
    let reason =
        |system: &PoissonSystem, potential: &str| match DarbouxMagnetic::realize(system, potential)
            .expect_err("refused")
        {
            BuildError::DoesNotFit { part, reason } => {
                assert_eq!(part, "darboux-magnetic");
                reason
            }
            other => panic!("{other}"),
        };
    assert_eq!(
        reason(&magnetic, "0; x^3/3; y^2/2"),
        "{px, pz} is not -dA(px)/dz + dA(pz)/dx, so that px - A(px) and pz - A(pz) do not commute"
    );
    assert!(reason(&library("rigid-body").system, POTENTIAL).contains("`x1`"));
    let scaled = from_formulas(&["x", "p"], &[], &[("x,p", "2")], "x", &[]);
    assert!(reason(&scaled, "0").contains("{x, p} is not 1 or -1"));
}

#[test]
fn a_potential_that_cannot_be_read_says_what_to_write() {
    let magnetic = library("magnetic").system;
    let part = Registry::with_builtin()
        .realization("darboux-magnetic")
        .expect("linked");
    let refuse =
        |parameters: PartParameters| match part.build(&magnetic, &parameters).expect_err("refused")
        {
            BuildError::Parameter {
                parameter,
                expected,
                ..
            } => {
                assert_eq!(parameter, "potential");
                assert!(
                    expected.contains("formulas of x, y, z for the momenta px, py, pz"),
                    "{expected}"
                );
                expected
            }
            other => panic!("{other}"),
        };
    assert!(refuse(PartParameters::new()).contains("missing"));
    let with = |text: &str| PartParameters::new().with("potential", text);
    assert!(refuse(with("0; x^3/3")).contains("2 components"));
    assert!(refuse(with("0; w^3/3; 0")).contains("for py: unknown"));
    assert!(refuse(with("0; x^; 0")).contains("for py"));
    assert!(refuse(with("0; px; 0")).contains("the momentum px"));
    assert!(part.build(&magnetic, &with(POTENTIAL)).is_ok());
}
