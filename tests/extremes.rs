//! Degenerate systems, equilibria, tiny and huge steps and states, states that are not numbers.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::{
    Integrator, Method, PartParameters, PoissonSystem, Registry, StepError, StepMap,
};
use leafwise::expression::{Arithmetic, Graph, Kernel, StepSize, Term};
use leafwise_tests::methods::increment;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{library, method};
use proptest::collection::vec;
use proptest::prelude::*;

const SO3: [(&str, &str); 3] = [("x1,x2", "-x3"), ("x2,x3", "-x1"), ("x3,x1", "-x2")];
const NAMES: [&str; 3] = ["x1", "x2", "x3"];

/// Asserts that ten steps change neither the state nor its compensation by a bit.
fn assert_at_rest(name: &str, system: &PoissonSystem, x: &[f64]) {
    for (n, m) in [(1, 2), (4, 4), (6, 6)] {
        let method = method(system, n, m);
        let parameters = system.parameter_values();
        let mut integrator = Integrator::new(&method, &parameters, 0.1, 2.0, x);
        for _ in 0..10 {
            integrator
                .step()
                .unwrap_or_else(|error| panic!("{name} n = {n} m = {m}: {error}"));
        }
        let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(integrator.state()), bits(x), "{name} n = {n} m = {m}");
        assert!(
            integrator.compensation().iter().all(|low| *low == 0.0),
            "{name}"
        );
    }
}

#[test]
fn without_a_hamiltonian_nothing_moves_by_a_bit() {
    for hamiltonian in ["0", "7/3", "0*x1", "x2 - x2"] {
        let system = from_formulas(&NAMES, &[], &SO3, hamiltonian, &[]);
        assert_at_rest(hamiltonian, &system, &[0.1, -1.0 / 3.0, 5.7e5]);
    }
}

#[test]
fn without_a_tensor_nothing_moves_by_a_bit() {
    for bracket in [&[][..], &[("x1,x2", "0"), ("x2,x3", "x1 - x1")]] {
        let system = from_formulas(&NAMES, &[], bracket, "x1^2*x3 + exp(x2)", &[]);
        assert_at_rest("no tensor", &system, &[0.1, -1.0 / 3.0, 5.7]);
    }
}

#[test]
fn equilibria_stay_fixed_to_the_bit() {
    let body = library("rigid-body").system;
    for x in [[0.0; 3], [1.7, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 3.3]] {
        assert_at_rest("rigid body", &body, &x);
    }
    let top = library("heavy-top").system;
    assert_at_rest("heavy top", &top, &[0.0; 6]);
    // Where two species of three are extinct the third has nothing to eat.
    let species = library("lotka-volterra").system;
    for x in [[0.0; 3], [1.1, 0.0, 0.0], [0.0, 2.3, 0.0], [0.0, 0.0, 0.7]] {
        assert_at_rest("Lotka-Volterra", &species, &x);
    }
}

#[test]
fn a_coordinate_plane_of_lotka_volterra_is_never_left() {
    let system = library("lotka-volterra").system;
    for (n, m) in [(3, 2), (8, 4)] {
        let method = method(&system, n, m);
        for zero in 0..3 {
            let mut x = [0.9, 1.4, 0.6];
            x[zero] = 0.0;
            let mut integrator = Integrator::new(&method, &[], 0.01, 2.0, &x);
            for _ in 0..100 {
                integrator.step().expect("a step in a coordinate plane");
                assert_eq!(
                    integrator.state()[zero],
                    0.0,
                    "x{} after extinction",
                    zero + 1
                );
            }
            assert!(distance(integrator.state(), &x) > 0.1, "the others move");
        }
    }
}

/// One step of t = 1e-12 is t X_H(x) up to t²|DX X|/2, some 1e-11 relative, and round-off of the
/// increment, which is formed without subtracting states: 1e-10 relative to it.
#[test]
fn tiny_steps_keep_the_relative_accuracy_of_their_increment() {
    for id in [
        "rigid-body",
        "heavy-top",
        "lotka-volterra-periodic",
        "gradient",
        "magnetic",
    ] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4);
        let t = 1e-12;
        let found =
            increment(&method, &parameters, (1.0, t), &problem.initial).expect("a tiny step");
        let kernel = problem
            .system
            .expressions()
            .expect("formulas")
            .vector_field_kernel()
            .expect("a vector field");
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &parameters, &[1.0], &[1.0]);
        let mut field = vec![0.0; problem.initial.len()];
        kernel.evaluate(&mut workspace, &problem.initial, &mut field);
        field.iter_mut().for_each(|f| *f *= t);
        let error = distance(&found, &field) / largest(&field);
        println!(
            "{id}: relative error {error:.1e} of an increment {:.1e}",
            largest(&field)
        );
        assert!(error <= 1e-10, "{id}: {found:?} {field:?}");
        let nothing = increment(&method, &parameters, (1.0, 0.0), &problem.initial);
        assert_eq!(
            nothing.expect("no step"),
            vec![0.0; field.len()],
            "{id}: t = 0"
        );
    }
}

/// β̂∘L of a method, compiled apart from its solver: |base| + |offset| and base + offset.
struct Target {
    kernel: Kernel,
}

impl Target {
    fn new(system: &PoissonSystem, method: &Method) -> Self {
        let d = system.dimension();
        let mut graph = Graph::new();
        let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let (epsilon, h) = (
            graph.step_size(StepSize::Epsilon),
            graph.step_size(StepSize::H),
        );
        let points = method.bisection().code().expect("code");
        let z = points.point(&mut graph, &epsilon, &h, &y).expect("code");
        let ends = method.realization().code().expect("code");
        let ends = ends
            .source_and_target(&mut graph, &epsilon, &z)
            .expect("code");
        let target: Vec<Term> = (0..d)
            .map(|i| graph.add(&ends.base[i], &ends.offset[i]))
            .collect();
        let outputs = [target, ends.offset].concat();
        Self {
            kernel: Kernel::compile(&graph, &outputs, system.parameters().len(), d),
        }
    }

    /// |β̂(L(y)) − x| relative to |x| + |y| + |β̂ − y|.
    fn residual(&self, parameters: &[f64], (epsilon, h): (f64, f64), x: &[f64], y: &[f64]) -> f64 {
        let mut workspace = self.kernel.workspace(1);
        self.kernel
            .prepare(&mut workspace, parameters, &[epsilon], &[h]);
        let mut values = vec![0.0; 2 * x.len()];
        self.kernel.evaluate(&mut workspace, y, &mut values);
        let (target, offset) = values.split_at(x.len());
        distance(target, x) / (largest(x) + largest(y) + largest(offset))
    }
}

/// The outcome of one cold step: finite with a solution, or an error and no increment.
fn attempt(
    method: &Method,
    parameters: &[f64],
    (epsilon, h): (f64, f64),
    x: &[f64],
) -> Result<Vec<f64>, StepError> {
    let d = x.len();
    let mut increment = vec![f64::NAN; d];
    let mut outcome = [Ok(())];
    let mut stepper = method.stepper(1, parameters, epsilon, h);
    stepper.increment(x, &vec![0.0; d], &mut increment, &mut outcome);
    let [outcome] = outcome;
    match outcome {
        Ok(()) => {
            assert!(
                increment.iter().all(|i| i.is_finite()),
                "{increment:?} from {x:?}"
            );
            Ok(stepper.solution(0).expect("a solved equation"))
        }
        Err(error) => {
            assert_eq!(increment, vec![0.0; d], "a failed step has no increment");
            assert!(error.to_string().len() > 20, "{error}");
            Err(error)
        }
    }
}

/// A step that reports success solved its equation, however large it is: the residual is round-off
/// of the equation's own terms, a few hundred operations deep.
#[test]
fn huge_steps_fail_with_a_reason_or_solve_their_equation() {
    let (mut solved, mut failed) = (0, 0);
    for id in [
        "rigid-body",
        "lotka-volterra",
        "lotka-volterra-periodic",
        "heavy-top",
        "gradient",
    ] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        for (n, m) in [(2, 2), (6, 4)] {
            let method = method(&problem.system, n, m);
            let target = Target::new(&problem.system, &method);
            for t in [0.3, 1.0, 3.0, 10.0, 100.0, 1e4, 1e8, 1e200, 1e308] {
                match attempt(&method, &parameters, (1.0, t), &problem.initial) {
                    Ok(y) => {
                        let residual = target.residual(&parameters, (1.0, t), &problem.initial, &y);
                        assert!(
                            residual <= 1e3 * UNIT_ROUNDOFF,
                            "{id} t = {t}: {residual:e}"
                        );
                        solved += 1;
                    }
                    Err(_) => failed += 1,
                }
            }
        }
    }
    println!("{solved} huge steps solved their equation, {failed} were refused");
    assert!(solved > 0 && failed > 0, "both outcomes occur");
}

/// The rigid body at λx with the step t/λ is λ times the rigid body at x: exactly the same
/// operations with exponents shifted where λ is a power of 2.
#[test]
fn large_and_small_states_are_as_accurate_as_any() {
    let system = library("rigid-body").system;
    let parameters = system.parameter_values();
    let method = method(&system, 4, 2);
    let x = [1.0, 3.0, 3.0];
    let own = increment(&method, &parameters, (1.0, 0.125), &x).expect("a step");
    for exponent in [-300.0, -100.0, -3.0, 3.0, 100.0, 200.0] {
        let lambda = libm::exp2(exponent);
        let scaled = x.map(|x| x * lambda);
        let found = increment(&method, &parameters, (1.0, 0.125 / lambda), &scaled);
        let found: Vec<f64> = found
            .expect("a scaled step")
            .iter()
            .map(|i| i / lambda)
            .collect();
        assert!(
            distance(&found, &own) <= 50.0 * UNIT_ROUNDOFF * 3.0,
            "2^{exponent}: {found:?}"
        );
    }
}

#[test]
fn states_at_the_ends_of_the_doubles_give_numbers_or_errors() {
    for id in [
        "rigid-body",
        "lotka-volterra",
        "lotka-volterra-periodic",
        "heavy-top",
        "gradient",
    ] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4);
        for size in [5e-324, 1e-300, 1e-150, 1e150, 1e300] {
            let x: Vec<f64> = problem.initial.iter().map(|x| x * size).collect();
            let mut integrator = Integrator::new(&method, &parameters, 0.1, 1.0, &x);
            for _ in 0..5 {
                let before = integrator.state().to_vec();
                match integrator.step() {
                    Ok(()) => assert!(integrator.state().iter().all(|x| x.is_finite()), "{id}"),
                    Err(error) => {
                        println!("{id} at size {size:e}: {error}");
                        assert_eq!(integrator.state(), before, "{id}: the state is intact");
                        break;
                    }
                }
            }
        }
    }
}

#[test]
fn states_that_are_not_numbers_or_outside_the_domain_are_refused() {
    for id in ["rigid-body", "lotka-volterra", "heavy-top", "gradient"] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 2);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for at in 0..problem.initial.len() {
                let mut x = problem.initial.clone();
                x[at] = bad;
                let outcome = attempt(&method, &parameters, (0.1, 1.0), &x);
                assert!(
                    matches!(outcome, Err(StepError::NonFinite { .. })),
                    "{id}: x{at} = {bad}: {outcome:?}"
                );
            }
        }
    }
    let problem = library("lotka-volterra-periodic");
    let method = method(&problem.system, 4, 4);
    let outcome = attempt(
        &method,
        &problem.system.parameter_values(),
        (0.1, 1.0),
        &[1.0, -1.9, 0.0],
    );
    assert!(
        matches!(outcome, Err(StepError::NonFinite { .. })),
        "ln(0): {outcome:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Any state and any step of any size: a finite increment or an error, never a NaN.
    #[test]
    fn no_step_is_silently_garbage(
        which in 0..4_usize,
        x in vec((-300.0..300.0_f64, any::<bool>()), 6),
        t in (-12.0..12.0_f64, any::<bool>()),
    ) {
        let number = |(exponent, minus): (f64, bool)| {
            libm::exp10(exponent) * if minus { -1.0 } else { 1.0 }
        };
        let id = ["rigid-body", "lotka-volterra", "heavy-top", "gradient"][which];
        let problem = library(id);
        let x: Vec<f64> =
            x.into_iter().take(problem.initial.len()).map(number).collect();
        let method = method(&problem.system, 3, 2);
        // The assertions are in `attempt`.
        let _ = attempt(&method, &problem.system.parameter_values(), (1.0, number(t)), &x);
    }
}

/// A coordinate may be zero at the start, stay zero, or be the round-off of larger ones: none of
/// that is a reason to fail. Each of the library's systems from its default state with any subset
/// of the coordinates set to zero.
#[test]
fn states_with_zero_components_step_as_any_other() {
    for id in [
        "three-wave",
        "magnetic",
        "so4",
        "heavy-top",
        "gradient",
        "se3",
        "rigid-body",
    ] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        let method = method(&problem.system, 4, 4);
        let d = problem.initial.len();
        for zeros in 0_u32..1 << d {
            let mut x = problem.initial.clone();
            (0..d)
                .filter(|i| zeros >> i & 1 == 1)
                .for_each(|i| x[i] = 0.0);
            let mut integrator = Integrator::new(&method, &parameters, 1.0, 0.05, &x);
            for step in 0..30 {
                let outcome = integrator.step();
                assert!(outcome.is_ok(), "{id} from {x:?}, step {step}: {outcome:?}");
            }
            let most = integrator.statistics().most_evaluations;
            assert!(most <= 8, "{id} from {x:?}: {most} evaluations");
        }
    }
}

/// Two coupled oscillators in other coordinates, at rest but for one; and a heavy top whose
/// equilibrium is not an exact zero of its rounded equations.
#[test]
fn components_that_are_round_off_of_others_converge() {
    let oscillators = from_formulas(
        &["q", "r", "p", "s"],
        &[],
        &[("q,p", "-1"), ("r,s", "-1")],
        "p^2/2 + s^2/2 + (q - r)^2/2",
        &[],
    );
    let top = from_formulas(
        &["m1", "m2", "m3", "g1", "g2", "g3"],
        &[],
        &[
            ("m1,m2", "-m3"),
            ("m2,m3", "-m1"),
            ("m3,m1", "-m2"),
            ("m1,g2", "-g3"),
            ("m2,g3", "-g1"),
            ("m3,g1", "-g2"),
            ("m2,g1", "g3"),
            ("m3,g2", "g1"),
            ("m1,g3", "g2"),
        ],
        "m1^2/2 + m2^2/1.5 + m3^2/2.5 + 0.3*g1 + 0.6*g2 + 0.9*g3",
        &[],
    );
    for (system, x) in [
        (oscillators, vec![0.0, 1.0, 0.0, 0.0]),
        (top, vec![0.0, 0.0, 0.0, 0.1, 0.2, 0.3]),
    ] {
        let method = method(&system, 2, 2);
        let mut integrator = Integrator::new(&method, &[], 1.0, 0.05, &x);
        for step in 0..200 {
            let outcome = integrator.step();
            assert!(outcome.is_ok(), "{x:?}, step {step}: {outcome:?}");
        }
    }
}

/// The same for parts that compute numbers: their solves are iterations of their own.
#[test]
fn zero_components_step_over_every_path() {
    let registry = Registry::with_builtin();
    for id in ["heavy-top", "so4", "rigid-body"] {
        let problem = library(id);
        let parameters = problem.system.parameter_values();
        for (realization, dynamics) in [
            ("karasev-collocated", "hamilton-jacobi"),
            ("lie-poisson", "hamilton-jacobi"),
            ("karasev-truncated", "collective"),
        ] {
            let defaults = PartParameters::new();
            let realization = registry
                .realization(realization)
                .and_then(|part| part.build(&problem.system, &defaults))
                .expect("a realization");
            let dynamics = registry
                .dynamics(dynamics)
                .and_then(|part| part.build(&defaults))
                .expect("a dynamic approximation");
            let method = Method::compose(&problem.system, realization, dynamics).expect("a pair");
            for kept in 0..problem.initial.len() {
                let mut x = vec![0.0; problem.initial.len()];
                x[kept] = 1.0;
                let mut integrator = Integrator::new(&method, &parameters, 1.0, 0.05, &x);
                for step in 0..30 {
                    let outcome = integrator.step();
                    let name = method.describe();
                    assert!(
                        outcome.is_ok(),
                        "{id}, {name} from {x:?}, {step}: {outcome:?}"
                    );
                }
            }
        }
    }
}
