//! Gauss steps in logarithms are Poisson maps of a log-canonical tensor.

use std::sync::Arc;

use leafwise_collective::{Collective, SymplecticIntegrator};
use leafwise_core::{
    BuildError, Correction, DynamicApproximation, Method, PoissonSystem, RealizationData, StepError,
};
use leafwise_hamilton_jacobi::HamiltonJacobi;
use leafwise_logarithms::Logarithms;
use leafwise_tests::gauss::flow;
use leafwise_tests::methods::{assert_resumes, increment, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::orders::assert_gauss_orders;
use leafwise_tests::structure::structure_error;
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{Problem, library};
use proptest::collection::vec;
use proptest::prelude::*;

fn compose(
    system: &PoissonSystem,
    dynamics: impl DynamicApproximation + 'static,
) -> Result<Method, BuildError> {
    let realization: Arc<dyn RealizationData> = Arc::new(Logarithms::realize(system)?);
    Method::compose(system, realization, Arc::new(dynamics))
}

fn collective(integrator: SymplecticIntegrator) -> Collective {
    Collective::new(integrator, Correction::Bisection).expect("an integrator")
}

fn gauss(system: &PoissonSystem, stages: usize) -> Method {
    compose(system, collective(SymplecticIntegrator::Gauss(stages))).expect("a method")
}

/// Three species with a coefficient that is a function of the parameters, one entry not written as a product.
fn three_species(hamiltonian: &str) -> PoissonSystem {
    from_formulas(
        &["x1", "x2", "x3"],
        &[("a", 1.3)],
        &[
            ("x1,x2", "x1*x2"),
            ("x3,x1", "exp(-a)*x1*x3"),
            ("x2,x3", "x2*x3^2/x3/2"),
        ],
        hamiltonian,
        &[],
    )
}

const ENERGY: &str = "x1 + x2^2/3 + x1*x3/2 + a*x3";

proptest! {
    #[test]
    fn steps_are_poisson_maps(
        x in vec(0.3..2.0_f64, 3),
        signs in vec(any::<bool>(), 3),
        stages in 1..=8_usize,
        time_step in 0.01..0.1_f64,
    ) {
        let pairs = x.iter().zip(signs);
        let signed: Vec<f64> = pairs.map(|(x, minus)| if minus { -x } else { *x }).collect();
        let system = three_species(ENERGY);
        let error = structure_error(&system, &gauss(&system, stages), time_step, &signed);
        let error = error.expect("a step");
        prop_assert!(error.tensor <= 64.0, "{signed:?}, {stages}, {time_step}: {error:?}");
        let Problem { system, .. } = library("lotka-volterra-periodic");
        let error = structure_error(&system, &gauss(&system, stages), time_step, &x);
        let error = error.expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{x:?}: {error:?}");
    }

    /// In y = ln x the tensor is constant: the step is that of the Gauss method written out there.
    #[test]
    fn the_step_is_that_of_the_written_out_logarithms(
        y in vec(-0.7..0.7_f64, 3),
        time_step in 0.01..0.15_f64,
    ) {
        let x: Vec<f64> = y.iter().map(|y| libm::exp(*y)).collect();
        let system = three_species("x1 + x2 + x3 - ln(x2) + x1*x3");
        let written = from_formulas(
            &["y1", "y2", "y3"],
            &[("a", 1.3)],
            &[("y1,y2", "1"), ("y3,y1", "exp(-a)"), ("y2,y3", "1/2")],
            "exp(y1) + exp(y2) + exp(y3) - y2 + exp(y1 + y3)",
            &[],
        );
        let oracle = leafwise_tests::gauss::implicit_midpoint(&written, time_step, &y);
        let step = increment(&gauss(&system, 1), &[1.3], (1.0, time_step), &x).expect("a step");
        for i in 0..3 {
            let expected = libm::exp(oracle[i]);
            // y and its exponentials are known to a rounding each, the oracle's iteration settles to a few.
            let bound = 16.0 * UNIT_ROUNDOFF * (1.0 + oracle[i].abs()) * expected;
            let error = (x[i] + step[i] - expected).abs();
            prop_assert!(error <= bound, "x{}: {error:e}, {bound:e}", i + 1);
        }
    }

    /// About the state z is 0: a coordinate in another unit takes the same steps.
    #[test]
    fn units_change_no_bit(exponents in vec(-60..60_i32, 3), stages in 1..=16_usize) {
        let units: Vec<f64> = exponents.iter().map(|k| libm::exp2(f64::from(*k))).collect();
        let in_units = |units: &[f64]| {
            from_formulas(
                &["x1", "x2", "x3"],
                &[("u1", units[0]), ("u2", units[1]), ("u3", units[2])],
                &[("x1,x2", "x1*x2"), ("x3,x1", "x1*x3/3"), ("x2,x3", "x2*x3")],
                "x1/u1 + x2/u2 + x3/u3 - 2*ln(x2) + x1/u1*(x3/u3)",
                &[],
            )
        };
        let (own, other) = (in_units(&[1.0; 3]), in_units(&units));
        let initial = [0.7, 1.9, 1.2];
        let far: Vec<f64> = initial.iter().zip(&units).map(|(x, unit)| x * unit).collect();
        let near = run(&own, &gauss(&own, stages), (1.0, 0.1), 10, &initial).expect("steps");
        let far = run(&other, &gauss(&other, stages), (1.0, 0.1), 10, &far).expect("steps");
        for i in 0..3 {
            prop_assert_eq!(near[i], far[i] / units[i]);
        }
    }
}

#[test]
fn gauss_methods_have_order_2s() {
    let Problem {
        system, initial, ..
    } = library("lotka-volterra-periodic");
    let fits = [
        (1, 2.0, [20, 40, 80, 160]),
        (2, 2.0, [10, 20, 40, 80]),
        (4, 2.0, [8, 12, 16, 24]),
    ];
    assert_gauss_orders(&system, |stages| gauss(&system, stages), &initial, &fits);
    // Of order 16 two errors are above round-off: they fall by more than those of order 15 would.
    let end = flow(&system, &initial, 2.0, 64);
    let [first, second] = [3, 4].map(|steps| {
        let step = (1.0, 2.0 / steps as f64);
        distance(
            &run(&system, &gauss(&system, 8), step, steps, &initial).expect("steps"),
            &end,
        )
    });
    assert!(
        second > 1e-12 && first / second > libm::pow(4.0 / 3.0, 15.0),
        "{first:e}, {second:e}"
    );
}

#[test]
fn a_coordinate_that_is_zero_stays_zero() {
    let system = three_species(ENERGY);
    let end = run(
        &system,
        &gauss(&system, 4),
        (1.0, 0.1),
        50,
        &[0.8, 0.0, -0.4],
    );
    let end = end.expect("steps");
    assert_eq!(end[1].to_bits(), 0.0_f64.to_bits());
    assert!(end[0] > 0.0 && end[2] < 0.0, "{end:?}");
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    let Problem {
        system, initial, ..
    } = library("lotka-volterra-periodic");
    assert_resumes(&system, &gauss(&system, 8), 0.3, &initial);
}

/// A step that no iteration contracts, and one whose stages have no value, are typed errors.
#[test]
fn steps_that_are_too_long_are_refused() {
    let Problem {
        system, initial, ..
    } = library("lotka-volterra-periodic");
    let parameters = system.parameter_values();
    let too_long = increment(&gauss(&system, 4), &parameters, (1.0, 30.0), &initial);
    let is_typed = matches!(
        too_long,
        Err(StepError::NoConvergence { .. } | StepError::NonFinite { .. })
    );
    assert!(is_typed, "{too_long:?}");
    let pole = three_species("x1 + 1/(x2 - 1)");
    let at_pole = increment(&gauss(&pole, 4), &[1.3], (1.0, 0.1), &[1.0, 1.0, 1.0]);
    let is_typed = matches!(at_pole, Err(StepError::NonFinite { .. }));
    assert!(is_typed, "{at_pole:?}");
}

#[test]
fn other_tensors_and_other_dynamics_are_refused() {
    let other = from_formulas(&["x", "y"], &[], &[("x,y", "x*y + 1")], "x + y", &[]);
    let refused = Logarithms::realize(&other).map(|_| ());
    let is_misfit = matches!(refused, Err(BuildError::DoesNotFit { .. }));
    assert!(is_misfit, "{refused:?}");
    let system = three_species(ENERGY);
    let verlet = compose(&system, collective(SymplecticIntegrator::StormerVerlet));
    let hamilton_jacobi = compose(&system, HamiltonJacobi::new(2).expect("an order"));
    for refused in [verlet, hamilton_jacobi] {
        let refused = refused.map(|_| ());
        let is_typed = matches!(
            refused,
            Err(BuildError::Incompatible { .. } | BuildError::LiftAlone { .. })
        );
        assert!(is_typed, "{refused:?}");
    }
}
