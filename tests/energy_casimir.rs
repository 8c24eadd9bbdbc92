//! Hamilton–Jacobi made from an energy–Casimir function: the motion of H, a smaller error.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise::core::diagnostics::TensorDefect;
use leafwise::core::{
    BuildError, Method, PartParameters, PoissonSystem, RealizationData, Registry,
};
use leafwise_tests::methods::run;
use leafwise_tests::numbers::{distance, largest};
use leafwise_tests::orders::measure;
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{gauss, library};
use proptest::prelude::*;

const TIME: f64 = 1.0;
const STEPS: [usize; 6] = [6, 8, 11, 16, 22, 32];
const EPSILON: f64 = 0.5;

fn built(
    system: &PoissonSystem,
    realization: &str,
    m: i64,
    hamiltonian: &str,
) -> Result<Method, BuildError> {
    let registry = Registry::with_builtin();
    let realization: Arc<dyn RealizationData> = registry
        .realization(realization)
        .expect("a built-in realization")
        .build(system, &PartParameters::new())?;
    let parameters = PartParameters::new()
        .with("order", m)
        .with("hamiltonian", hamiltonian);
    let dynamics = registry
        .dynamics("hamilton-jacobi")
        .expect("a built-in dynamic approximation")
        .build(&parameters)?;
    Method::compose(system, realization, dynamics)
}

/// (t, error relative to the state) over [`STEPS`].
fn errors(system: &PoissonSystem, method: &Method, initial: &[f64]) -> Vec<(f64, f64)> {
    let exact = gauss::flow(system, initial, TIME, 300);
    let error = |steps: usize| {
        let t = TIME / steps as f64;
        let end = run(system, method, (EPSILON, t / EPSILON), steps, initial).expect("converges");
        (t, distance(&end, &exact) / largest(&exact))
    };
    STEPS.map(error).to_vec()
}

/// Where the library's systems turn freely the function is shorter: the map keeps its order and its
/// structure, and errs less at every step.
#[test]
fn the_order_and_the_structure_are_those_of_h_and_the_error_is_smaller() {
    for id in ["rigid-body", "so4", "se3"] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        for m in [2, 4] {
            let [given, less] = ["given", "energy-casimir"].map(|hamiltonian| {
                built(&problem.system, "lie-poisson", m, hamiltonian).expect("the parts fit")
            });
            let [plain, small] =
                [&given, &less].map(|method| errors(&problem.system, method, &problem.initial));
            let order = measure(&small, 2.0 * f64::EPSILON, 2.0).expect("above round-off");
            println!("{id}, m = {m}: order {order}, errors {plain:?} and {small:?}");
            assert!(order.is(m as f64, 2.0), "{id}, m = {m}: {order}");
            for ((_, plain), (_, small)) in plain.iter().zip(&small) {
                assert!(small < plain, "{id}, m = {m}: {small:e} {plain:e}");
            }
            let t = TIME / STEPS[0] as f64;
            let mut instrument =
                TensorDefect::new(&problem.system, &less, &parameters, EPSILON, t / EPSILON)
                    .expect("a tensor");
            let defect = instrument.measure(&problem.initial).expect("a step");
            let relative = defect.relative().expect("the tensor does not vanish");
            assert!(
                relative <= leafwise::core::diagnostics::Defect::ROUND_OFF,
                "{id}, m = {m}: {relative:e}"
            );
        }
    }
}

#[test]
fn a_system_without_such_a_function_is_refused_with_what_to_take() {
    let system = library("heavy-top").system;
    let refused = built(&system, "lie-poisson", 2, "energy-casimir").expect_err("no such function");
    assert!(
        matches!(refused, BuildError::DoesNotFit { .. }),
        "{refused:?}"
    );
    assert_eq!(
        refused.to_string(),
        "hamilton-jacobi does not fit this system: no multiple of its Casimirs leaves a Hamiltonian \
         with smaller coefficients: take hamiltonian = \"given\""
    );
    let numbers = library("rigid-body").system;
    let numbers = numbers.without_formulas("a body").expect("numbers");
    let refused =
        built(&numbers, "karasev-collocated", 2, "energy-casimir").expect_err("no formulas");
    assert!(
        matches!(refused, BuildError::NotOffered { .. }),
        "{refused:?}"
    );
}

fn body(inertia: [f64; 3], multiple: f64) -> PoissonSystem {
    let [a, b, c] = inertia;
    from_formulas(
        &["x1", "x2", "x3"],
        &[("a", a), ("b", b), ("c", c), ("m", multiple)],
        &[("x1,x2", "-x3"), ("x2,x3", "-x1"), ("x3,x1", "-x2")],
        "x1^2/(2*a) + x2^2/(2*b) + x3^2/(2*c) + m*(x1^2 + x2^2 + x3^2)",
        &[("spin", "x1^2 + x2^2 + x3^2")],
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Which multiple of the Casimir H already holds does not matter: the function that is left is the
    /// same formula, so the steps are the same doubles.
    #[test]
    fn what_h_holds_of_a_casimir_does_not_matter(
        inertia in prop::array::uniform3(0.3..3.0_f64),
        multiple in 0.0..5.0_f64,
        x in prop::array::uniform3(-2.0..2.0_f64),
        t in 0.01..0.2_f64,
    ) {
        let end = |multiple: f64| {
            let system = body(inertia, multiple);
            let method = built(&system, "so3-exponential", 6, "energy-casimir").expect("shorter");
            run(&system, &method, (1.0, t), 5, &x).expect("converges")
        };
        prop_assert_eq!(end(0.0), end(multiple));
    }
}
