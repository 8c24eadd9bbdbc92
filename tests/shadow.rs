//! Shadow Hamiltonians: what a map keeps to a higher order than its own.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise::core::diagnostics::{Defect, TensorDefect};
use leafwise::core::{
    Method, PartParameters, PoissonSystem, Registry, Shadow, StepMap, Structure, SystemFormulas,
    Walk,
};
use leafwise::expression::{Arithmetic, Expression, Rational, Ring};
use leafwise::scene::compose::ShadowEnergy;
use leafwise_tests::orders::{MeasuredOrder, measure};
use leafwise_tests::scenes::composed;
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{Problem, library, method};
use proptest::prelude::*;

const PRODUCTS: u64 = 1 << 24;

/// Steps over the time.
const STEPS: [usize; 10] = [8, 10, 12, 14, 16, 20, 24, 28, 32, 40];

fn formulas(system: &PoissonSystem) -> &SystemFormulas {
    system.expressions().expect("a system of formulas")
}

fn shadow(system: &PoissonSystem, map: &dyn StepMap, last: usize) -> Shadow {
    let shadow = map.shadow(formulas(system), last, PRODUCTS);
    shadow.expect("in the algebra").expect("a shadow")
}

/// Hamilton–Jacobi of order m over the first of these realizations that fits.
fn hamilton_jacobi(system: &PoissonSystem, m: usize) -> Arc<dyn StepMap> {
    let registry = Registry::with_builtin();
    let exact = registry.exact_realization(system, false);
    let realization = exact.expect("a closed form").realization;
    let dynamics = registry.dynamics("hamilton-jacobi").expect("a dynamics");
    let dynamics = dynamics
        .build(&PartParameters::new().with("order", m as i64))
        .expect("an even order");
    Arc::new(Method::compose(system, realization, dynamics).expect("the parts fit"))
}

/// A composition of the splitting, or the splitting itself.
fn split(system: &PoissonSystem, composition: Option<&str>) -> Arc<dyn StepMap> {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    let base = registry.stepper("splitting").expect("a stepper");
    let base = base.build(system, &none).expect("it fits");
    match composition {
        None => base,
        Some(name) => {
            let part = registry.composition(name).expect("a composition");
            part.build(base, &none).expect("it fits")
        }
    }
}

/// The mean size of a function's change over `steps` steps, relative to the function.
fn change(
    system: &PoissonSystem,
    map: &dyn StepMap,
    initial: &[f64],
    t: f64,
    steps: usize,
    function: &Expression,
) -> f64 {
    let parameters = formulas(system).parameter_values();
    let mut run = Walk::new(map, &parameters, 1.0, t, initial);
    let first = function.evaluate(initial, &parameters);
    let mut sum = 0.0_f64;
    for _ in 0..steps {
        run.step().expect("a step");
        let value = function.evaluate(run.state(), &parameters);
        sum += (value - first).abs();
    }
    sum / steps as f64 / first.abs()
}

/// The order at which H̃ with terms up to `last` changes over a fixed time.
fn order(
    system: &PoissonSystem,
    map: &dyn StepMap,
    initial: &[f64],
    (time, steps): (f64, &[usize]),
    last: usize,
) -> MeasuredOrder {
    let shadow = shadow(system, map, last);
    let point = |&steps: &usize| {
        let t = time / steps as f64;
        let function = shadow.value(t, last).expect("code").expect("a formula");
        (t, change(system, map, initial, t, steps, &function))
    };
    let points: Vec<_> = steps.iter().map(point).collect();
    measure(&points, 4.0 * f64::EPSILON, 2.0).unwrap_or_else(|| panic!("too few of {points:?}"))
}

fn every_term_adds_two_orders(name: &str, times: [f64; 3]) {
    let problem = library(name);
    for (m, time) in [2, 4, 6].into_iter().zip(times) {
        let map = hamilton_jacobi(&problem.system, m);
        each_adds_two(name, &problem, map.as_ref(), m, (time, &STEPS));
    }
}

fn each_adds_two(name: &str, problem: &Problem, map: &dyn StepMap, m: usize, at: (f64, &[usize])) {
    for terms in 0..=2 {
        let last = if terms == 0 { 1 } else { m + 2 * terms - 1 };
        let found = order(&problem.system, map, &problem.initial, at, last);
        let expected = m + 2 * terms;
        println!("{name} m = {m}: {expected} expected, {found} measured");
        // The orders that could be confused lie 2 apart.
        let error = (found.slope.exponent - expected as f64).abs();
        assert!(error < 0.5, "{name} m = {m}: {expected} expected, {found}");
    }
}

#[test]
fn every_term_adds_two_orders_on_the_rigid_body() {
    every_term_adds_two_orders("rigid-body", [2.0; 3]);
}

#[test]
fn every_term_adds_two_orders_on_the_heavy_top() {
    every_term_adds_two_orders("heavy-top", [2.0; 3]);
}

#[test]
fn every_term_adds_two_orders_on_periodic_lotka_volterra() {
    every_term_adds_two_orders("lotka-volterra-periodic", [0.5, 0.5, 0.8]);
}

#[test]
fn every_term_adds_two_orders_on_the_gradient_system() {
    every_term_adds_two_orders("gradient", [2.0; 3]);
}

#[test]
fn every_term_adds_two_orders_on_the_charged_particle() {
    every_term_adds_two_orders("magnetic", [2.0; 3]);
}

/// With three pieces; 3⁹ words and 4⁷.
#[test]
fn every_term_adds_two_orders_of_splittings() {
    let all = [(None, 2), (Some("suzuki-4"), 4), (Some("blanes-moan-6"), 6)];
    let problem = library("rigid-body");
    for (composition, m) in all {
        let map = split(&problem.system, composition);
        let name = format!("rigid body, {composition:?}");
        each_adds_two(&name, &problem, map.as_ref(), m, (2.0, &STEPS));
    }
    let problem = library("heavy-top");
    for (composition, m) in &all[..2] {
        let map = split(&problem.system, *composition);
        let name = format!("heavy top, {composition:?}");
        each_adds_two(&name, &problem, map.as_ref(), *m, (2.0, &STEPS));
    }
}

/// The midpoint rule turns the oscillator by 2 atan(t/2): H̃ = (2/t) atan(t/2) H.
#[test]
fn the_oscillators_shadow_is_the_series_of_the_arc_tangent() {
    let system = from_formulas(&["q", "p"], &[], &[("q,p", "1")], "(q^2 + p^2)/2", &[]);
    let found = shadow(&system, hamilton_jacobi(&system, 2).as_ref(), 9);
    let expected = [1.0, -1.0 / 12.0, 1.0 / 80.0, -1.0 / 448.0, 1.0 / 2304.0];
    assert_eq!(found.terms(), [1, 3, 5, 7, 9]);
    for (k, expected) in found.terms().into_iter().zip(expected) {
        let formula = found.formula(k, 100).expect("a formula");
        // At (1, 1) H is 1.
        let value = formula.evaluate(&[1.0, 1.0], &[]);
        assert!((value - expected).abs() < 1e-16, "F_{k}: {value}");
    }
}

/// Over a realization of order n the map is the flow of a Hamiltonian to order 2⌊n/2⌋ + 2 alone, whatever Ŝ is.
#[test]
fn a_truncated_realization_keeps_its_shadow_to_its_own_order() {
    let problem = library("rigid-body");
    for (n, expected) in [(2, 4.0), (3, 4.0), (4, 6.0), (6, 8.0)] {
        let map = method(&problem.system, n, 4);
        let found = order(&problem.system, &map, &problem.initial, (2.0, &STEPS), 9);
        println!("n = {n}: {found}");
        let error = (found.slope.exponent - expected).abs();
        assert!(error < 0.5, "n = {n}: {expected} expected, {found}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 24, ..ProptestConfig::default() })]

    /// Over a constant tensor F_3 = −⟨H″ f, f⟩/24 for the map of order 2, f the field of H: an identity of polynomials.
    #[test]
    fn the_first_term_over_a_constant_tensor_is_the_second_derivative_along_the_field(
        coefficients in prop::collection::vec(-4_i32..=4, 9),
    ) {
        let monomials = ["q", "p", "q^2", "q*p", "p^2", "q^3", "q^2*p", "q*p^2", "p^4"];
        let terms = coefficients.iter().zip(monomials);
        let text: Vec<String> = terms.map(|(c, m)| format!("({c})*{m}/3")).collect();
        let system = from_formulas(&["q", "p"], &[], &[("q,p", "1")], &text.join(" + "), &[]);
        let found = shadow(&system, hamilton_jacobi(&system, 2).as_ref(), 3);
        let mut ring = Ring::new(2);
        let mut read = |formula: &Expression| {
            let element = formula.evaluate_in(&mut ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)));
            element.expect("a polynomial")
        };
        let (energy, third) = (
            read(formulas(&system).hamiltonian()),
            read(&found.formula(3, 100).expect("a formula")),
        );
        let slopes = ring.gradient(&energy).expect("a polynomial");
        let field = [slopes[1].clone(), ring.negate(&slopes[0])];
        let mut sum = ring.zero();
        for (i, slope) in slopes.iter().enumerate() {
            let second = ring.gradient(slope).expect("a polynomial");
            for (j, second) in second.iter().enumerate() {
                let product = ring.multiply(&field[i], &field[j]);
                let product = ring.multiply(&product, second);
                sum = ring.add(&sum, &product);
            }
        }
        let expected = ring.scale(&Rational::new(-1, 24), &sum);
        prop_assert_eq!(third, expected);
    }
}

/// A charge in a field of degree r in its position: Karasev's series ends at ε^{r+1}, and what is cut off at n is nothing
/// where n > r. Then a step keeps the tensor to round-off, is declared to, and its shadow has no limit; below, neither.
#[test]
fn a_series_that_ends_is_exact_where_nothing_is_cut_off() {
    let mut exact = 0;
    for (field, degree) in [
        ("2", Some(0)),
        ("x + y/3", Some(1)),
        ("1 + x*y", Some(2)),
        ("b*x^2 - y^3", Some(3)),
        ("sin(x)", None),
        ("1/(2 + x)", None),
    ] {
        for n in 1..=5 {
            let run = composed(&format!(
                "[system]\nvariables = [\"x\", \"y\", \"u\", \"v\"]\nparameters = {{ b = 0 }}\n\
                 bracket = {{ \"x,u\" = \"-1\", \"y,v\" = \"-1\", \"u,v\" = \"{field}\" }}\n\
                 hamiltonian = \"(u^2 + v^2 + x^2 + y^4)/2\"\n\
                 [method]\nrealization = {{ name = \"karasev-truncated\", order = {n} }}\n\
                 dynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\ntime-step = 0.2\n\
                 [run]\ninitial = [0.7, 0.5, -0.4, 0.9]\nsteps = 1\n"
            ));
            let is_whole = degree.is_some_and(|degree| n > degree);
            let map = run.method.map();
            let is_declared = map.properties().structure == Structure::Exact;
            assert_eq!(is_declared, is_whole, "{field} {n}");
            let (values, t) = (run.system.parameter_values(), 0.2);
            let instrument = TensorDefect::new(&run.system, map, &values, 1.0, t);
            let defect = instrument.expect("formulas").measure(&run.plan.initial);
            let relative = defect.expect("a step").relative().expect("a tensor");
            // At b = 0 the field of degree 3 is one of y alone, and no lower.
            let is_kept = relative <= Defect::ROUND_OFF;
            assert_eq!(is_kept, is_whole, "{field} {n}: {relative:e}");
            let shadow = ShadowEnergy::of(&run.system, map, t, Some(8)).expect("a shadow");
            assert_eq!(
                shadow.limit.is_none(),
                is_whole || 2 * (n / 2) + 2 >= 8,
                "{field} {n}"
            );
            exact += usize::from(is_whole);
        }
    }
    assert_eq!(exact, 5 + 4 + 3 + 2);
}
