//! The realization of a direct sum with a constant tensor is exact.

use std::sync::Arc;

use leafwise_core::{BuildError, PoissonSystem, RealizationData, Registry};
use leafwise_direct_sum::DirectSum;
// Linked for the realizations that they register.
use leafwise_log_canonical as _;
use leafwise_so3 as _;
use leafwise_tests::realizations::{assert_dual_pair, assert_orders, assert_poisson_steps};
use leafwise_tests::systems::from_formulas;

fn realization(system: &PoissonSystem) -> Result<Arc<dyn RealizationData>, BuildError> {
    Ok(Arc::new(DirectSum::realize(
        system,
        &Registry::with_builtin(),
    )?))
}

/// so(3)* beside two canonical coordinates, coupled by H.
fn body_and_pendulum() -> PoissonSystem {
    from_formulas(
        &["x", "y", "z", "q", "p"],
        &[("a", 1.5)],
        &[("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y"), ("q,p", "-a")],
        "x^2/2 + y^2/3 + z^2/5 + p^2/2 - cos(q) + z*q/4",
        &[("spin", "x^2 + y^2 + z^2")],
    )
}

/// Three species in a season: log-canonical beside the time and its energy.
fn species_in_seasons() -> PoissonSystem {
    from_formulas(
        &["x", "y", "z"],
        &[("a", 0.7)],
        &[("x,y", "x*y"), ("y,z", "a*y*z"), ("x,z", "-x*z")],
        "x + y + z + x*cos(t)/4",
        &[],
    )
}

#[test]
fn the_maps_are_a_dual_pair() {
    for system in [body_and_pendulum(), species_in_seasons()] {
        let exact = realization(&system).expect("a direct sum");
        assert_dual_pair(&system, &exact, (-1.0..1.0, -1.0..1.0, 0.01..1.0), 16.0);
    }
}

#[test]
fn steps_are_poisson_and_keep_casimirs() {
    for system in [body_and_pendulum(), species_in_seasons()] {
        let exact = realization(&system).expect("a direct sum");
        assert_poisson_steps(&system, &exact, 0.5..1.5, 0.05);
    }
}

#[test]
fn the_order_is_that_of_the_dynamics() {
    let system = body_and_pendulum();
    let exact = realization(&system).expect("a direct sum");
    let initial = [0.8, 0.5, -0.6, 0.7, 0.4];
    let orders = [
        (2, [40, 57, 80, 113]),
        (4, [20, 28, 40, 57]),
        (6, [12, 16, 22, 30]),
    ];
    assert_orders(&system, &exact, (&initial, 1.0), &orders);
}

/// A central coordinate behind is a constant tensor too; where nothing is constant, or all, there is no sum.
#[test]
fn what_is_no_such_sum_is_refused() {
    let with = |bracket: &[(&str, &str)]| {
        let system = from_formulas(&["x", "y", "z", "c"], &[], bracket, "x + y*c", &[]);
        realization(&system).map(|realization| realization.describe())
    };
    let body = [("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y")];
    let described = with(&body).expect("so(3)* beside a coordinate that rests");
    assert_eq!(described, "direct-sum of so3-exponential and constant");
    let unfit = |bracket: &[(&str, &str)], reason: &str| {
        let error = with(bracket).expect_err("no direct sum");
        assert!(matches!(error, BuildError::DoesNotFit { .. }), "{error}");
        assert!(error.to_string().contains(reason), "{error}");
    };
    unfit(&[("x,y", "1"), ("z,c", "2")], "is not the direct sum");
    unfit(&[("x,y", "x*y"), ("z,c", "z*c")], "is not the direct sum");
    // The last coordinate enters the first ones' tensor.
    unfit(&[("x,y", "c")], "is not the direct sum");
    unfit(&[("x,y", "1 + x^2")], "has no code in pairs");
}
