//! so(3)*: a body that turns freely.

use leafwise_clebsch::algebras::rotations::{algebra, section};
use leafwise_clebsch::casimirs::grown;
use leafwise_core::{BuildError, PoissonSystem, Walk};
use leafwise_tests::gauss::flow;
use leafwise_tests::library;
use leafwise_tests::methods::{assert_resumes, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::orders::assert_gauss_orders;
use leafwise_tests::structure::structure_error;
use leafwise_tests::systems::from_formulas;
use proptest::collection::vec;
use proptest::prelude::*;

use super::common::{gauss, realize};

/// A body with products of inertia in a quartic field, λ = −k of the parameters.
fn body() -> PoissonSystem {
    from_formulas(
        &["x1", "x2", "x3"],
        &[("k", 1.5), ("a", 0.7)],
        &[("x1,x2", "k*x3"), ("x2,x3", "k*x1"), ("x3,x1", "k*x2")],
        "x1^2/2 + a*x2^2 + x3^2/3 + x1*x2/5 + x3^4/20 - x1/3",
        &[("spin", "x1^2 + x2^2 + x3^2")],
    )
}

proptest! {
    #[test]
    fn the_section_is_one(x in vec(-3.0..3.0_f64, 3), exponent in -200..200_i32) {
        let x: Vec<f64> = x.iter().map(|x| x * libm::exp2(f64::from(exponent))).collect();
        let z = section(&x);
        let size = largest(&x);
        let forms = algebra().forms;
        let (mut found, mut sizes) = ([0.0; 3], [0.0; 3]);
        forms.add_image(1.0, &z, &mut found, &mut sizes);
        // A root, a length and four products.
        prop_assert!(distance(&found, &x) <= 16.0 * UNIT_ROUNDOFF * size, "{x:?}: {found:?}");
        let square: f64 = z.iter().map(|z| z * z).sum();
        let mut rows = [[0.0; 4]; 3];
        for (k, row) in rows.iter_mut().enumerate() {
            forms.add_slopes(k, 1.0, &z, row);
        }
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..4).map(|a| rows[i][a] * rows[j][a]).sum();
                let expected = if i == j { 0.25 * square } else { 0.0 };
                prop_assert!((product - expected).abs() <= 8.0 * UNIT_ROUNDOFF * square);
            }
        }
    }

    #[test]
    fn steps_are_poisson_maps(
        x in vec(-2.0..2.0_f64, 3),
        stages in 1..=8_usize,
        time_step in 0.01..0.2_f64,
    ) {
        let system = body();
        let error = structure_error(&system, &gauss(&system, stages), time_step, &x);
        let error = error.expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{x:?}, {stages}: {error:?}");
    }

    /// So are steps that turn the body by a radian and more.
    #[test]
    fn long_steps_are_poisson_maps(
        x in vec(-2.0..2.0_f64, 3),
        stages in 4..=16_usize,
        time_step in 0.2..0.8_f64,
    ) {
        let system = body();
        // Steps that are too long for a state are refused.
        let error = structure_error(&system, &gauss(&system, stages), time_step, &x);
        prop_assume!(error.is_ok());
        let error = error.expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{x:?}, {stages}: {error:?}");
    }

    /// The square of a sum less the square, where most of it cancels.
    #[test]
    fn growth_is_rounded_once(z in prop::array::uniform4(-8..8_i32), delta in prop::array::uniform4(-8..8_i32)) {
        // Whole numbers with a tail of 2⁻³⁰: squares are known exactly in whole numbers of 2⁻⁶⁰.
        let tail = 1_i64 << 30;
        let wide = |v: [i32; 4]| v.map(|v| i64::from(v) * tail + 1);
        let (z, delta) = (wide(z), wide(delta));
        let exact: i128 = (0..4).map(|i| i128::from(delta[i]) * i128::from(2 * z[i] + delta[i])).sum();
        let real = |v: [i64; 4]| v.map(|v| v as f64 / tail as f64);
        let square: Vec<_> = (0..4).map(|i| (i, i, 1.0)).collect();
        let found = grown(&square, &real(z), &[0.0; 4], &real(delta));
        let expected = exact as f64 / (tail as f64 * tail as f64);
        prop_assert!((found - expected).abs() <= 2.0 * UNIT_ROUNDOFF * expected.abs(), "{found:e} {expected:e}");
    }
}

#[test]
fn gauss_methods_have_order_2s() {
    let system = body();
    let initial = [0.4, 1.1, -0.8];
    let fits = [
        (1, 2.0, [20, 40, 80, 160]),
        (2, 2.0, [10, 20, 40, 80]),
        (4, 4.0, [12, 16, 20, 26]),
    ];
    assert_gauss_orders(&system, |stages| gauss(&system, stages), &initial, &fits);
    let end = flow(&system, &initial, 2.0, 64);
    let found = run(&system, &gauss(&system, 16), (1.0, 0.5), 4, &initial).expect("steps");
    assert!(distance(&found, &end) <= 1e-13, "{found:?}, {end:?}");
}

/// The rigid body of the library: the spin wanders by the rounding of an increment, of the size of the state, a step.
#[test]
fn the_spin_is_kept_to_round_off() {
    const STEPS: usize = 400_000;
    let problem = library("rigid-body");
    let (system, initial) = (problem.system, problem.initial);
    let method = gauss(&system, 8);
    let parameters = system.parameter_values();
    let mut walk = Walk::new(&method, &parameters, 1.0, 0.7, &initial);
    let spin = |x: &[f64]| -> f64 { x.iter().map(|x| x * x).sum() };
    let before = spin(&initial);
    for _ in 0..STEPS {
        walk.step().expect("a step");
    }
    let drift = (spin(walk.state()) / before - 1.0).abs();
    // Without `hold` it is ten times as far, and further in proportion to the steps.
    let bound = 4.0 * libm::sqrt(STEPS as f64) * UNIT_ROUNDOFF;
    assert!(drift <= bound, "{drift:e}, {bound:e}");
}

#[test]
fn a_body_at_rest_rests() {
    let system = body();
    let end = run(&system, &gauss(&system, 4), (1.0, 0.1), 20, &[0.0; 3]).expect("steps");
    assert_eq!(end, [0.0; 3]);
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    let system = body();
    assert_resumes(&system, &gauss(&system, 8), 0.2, &[0.4, 1.1, -0.8]);
}

#[test]
fn other_tensors_are_refused() {
    let other = from_formulas(&["x", "y"], &[], &[("x,y", "1")], "x + y", &[]);
    let refused = realize(&other).map(|_| ());
    assert!(
        matches!(refused, Err(BuildError::DoesNotFit { .. })),
        "{refused:?}"
    );
}
