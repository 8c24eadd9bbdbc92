//! Straight-line kernels: their cost, their bits, their parameters.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::{Method, Registry, StepMap};
use leafwise::expression::{Expression, Function, Graph, Kernel, Rational, Term};
use leafwise::expression::{OperationCount, StepSize};
use leafwise::scene::SceneDocument;
use leafwise_tests::methods::increment;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::strategies::state;
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{Problem, library, method};
use proptest::collection::vec;
use proptest::prelude::*;

/// Operations of y ↦ dŜ(y) alone: what the step kernel spends on the dynamics.
fn differential(problem: &Problem, method: &Method) -> OperationCount {
    let d = problem.initial.len();
    let mut graph = Graph::new();
    let y: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let code = method.bisection().code().expect("code");
    let z = code(&mut graph, &epsilon, &h, &y).expect("code");
    let parameters = problem.system.parameters().len();
    Kernel::compile(&graph, &z[d..], parameters, d).step_operations()
}

#[test]
fn the_rigid_body_s_differential_to_s_7_takes_at_most_200_operations() {
    let body = library("rigid-body");
    for (m, most) in [(2, 3), (4, 200), (6, 200), (8, 200)] {
        let count = differential(&body, &method(&body.system, 2, m));
        println!("rigid body m = {m}: dS takes {count}");
        assert!(count.total() <= most, "m = {m}: {count}");
    }
    let top = library("heavy-top");
    println!(
        "heavy top m = 8: dS takes {}",
        differential(&top, &method(&top.system, 2, 8))
    );
}

/// A formula of four variables and two parameters.
fn formula() -> impl Strategy<Value = Expression> {
    let leaf = prop_oneof![
        (0..4_usize).prop_map(Expression::Variable),
        (0..2_usize).prop_map(Expression::Parameter),
        (-99..=99_i64, 1..=16_i64).prop_map(|(n, d)| Expression::Constant(Rational::new(n, d))),
        Just(Expression::Pi),
    ];
    leaf.prop_recursive(5, 40, 4, |inner| {
        let functions = prop::sample::select(Function::ALL.to_vec());
        let variable = (0..4_usize).prop_map(Expression::Variable);
        prop_oneof![
            vec(inner.clone(), 2..4).prop_map(Expression::Sum),
            vec(inner.clone(), 2..4).prop_map(Expression::Product),
            inner.clone().prop_map(|a| Expression::Negate(Box::new(a))),
            (inner.clone(), variable).prop_map(|(a, b)| Expression::Quotient(a.into(), b.into())),
            (inner.clone(), -3..=4_i64).prop_map(|(a, n)| {
                let exponent = Expression::Constant(Rational::from_integer(n));
                Expression::Power(a.into(), exponent.into())
            }),
            (functions, inner.clone()).prop_map(|(f, a)| Expression::Apply(f, a.into())),
            (inner.clone(), inner.clone(), inner)
                .prop_map(|(c, a, b)| Expression::Where(Box::new([c, a, b]))),
        ]
    })
}

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<u64> {
    // Which NaN an operation returns is not specified; that it is one is.
    values
        .into_iter()
        .map(|v| if v.is_nan() { u64::MAX } else { v.to_bits() })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Lane w of any number of lanes has the bits of that trajectory alone.
    #[test]
    fn every_lane_count_gives_the_same_bits(
        formulas in vec(formula(), 1..4),
        states in vec(state(4), 16),
        parameters in vec(state(2), 16),
    ) {
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..4).map(|i| graph.input(i)).collect();
        // Formulas that have no value at all, such as 1/0, are no formulas of a kernel.
        let outputs: Vec<Term> = formulas
            .iter()
            .filter_map(|f| f.evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone())).ok())
            .collect();
        prop_assume!(!outputs.is_empty());
        let kernel = Kernel::compile(&graph, &outputs, 2, 4);
        let evaluate = |lanes: std::ops::Range<usize>| -> Vec<Vec<f64>> {
            let pick = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
                lanes.clone().map(|w| rows[w % rows.len()].clone()).collect()
            };
            let transpose = |rows: &[Vec<f64>], width: usize| -> Vec<f64> {
                (0..width).flat_map(|j| rows.iter().map(move |row| row[j])).collect()
            };
            let count = lanes.len();
            let mut workspace = kernel.workspace(count);
            let ones = vec![1.0; count];
            let parameters = transpose(&pick(&parameters), 2);
            kernel.prepare(&mut workspace, &parameters, &ones, &ones);
            let mut values = vec![0.0; outputs.len() * count];
            kernel.evaluate(&mut workspace, &transpose(&pick(&states), 4), &mut values);
            (0..count)
                .map(|w| (0..outputs.len()).map(|j| values[j * count + w]).collect())
                .collect()
        };
        let alone: Vec<Vec<f64>> = (0..16).flat_map(|w| evaluate(w..w + 1)).collect();
        for count in [2, 3, 4, 7, 8, 12, 16, 32, 40, 64, 80] {
            for (w, together) in evaluate(0..count).into_iter().enumerate() {
                prop_assert_eq!(
                    bits(together), bits(alone[w % 16].clone()), "lane {} of {}", w, count
                );
            }
        }
    }

    /// Each lane of a stepper has the bits of its trajectory alone, whatever its neighbours do:
    /// lanes choose and freeze on their own tests.
    #[test]
    fn every_lane_of_a_step_has_the_bits_of_its_own_trajectory(
        states in vec(state(3), 11),
        h in 0.01..0.5_f64,
    ) {
        let body = library("rigid-body");
        let method = method(&body.system, 4, 4);
        let parameters = body.system.parameter_values();
        for count in [3, 8, 11] {
            let wide: Vec<f64> =
                parameters.iter().flat_map(|p| std::iter::repeat_n(*p, count)).collect();
            let mut together = method.stepper(count, &wide, 0.5, h);
            let mut alone: Vec<_> =
                (0..count).map(|_| method.stepper(1, &parameters, 0.5, h)).collect();
            let mut x: Vec<f64> =
                (0..3).flat_map(|j| states[..count].iter().map(move |x| x[j])).collect();
            let mut increments = vec![0.0; 3 * count];
            let mut outcome = vec![Ok(()); count];
            // Long enough for histories of full length and for Jacobians that are kept.
            for step in 0..20 {
                together.increment(&x, &vec![0.0; 3 * count], &mut increments, &mut outcome);
                for (w, alone) in alone.iter_mut().enumerate() {
                    let own_x: Vec<f64> = (0..3).map(|j| x[j * count + w]).collect();
                    let (mut own, mut own_outcome) = (vec![0.0; 3], [Ok(())]);
                    alone.increment(&own_x, &[0.0; 3], &mut own, &mut own_outcome);
                    let lane = (0..3).map(|j| increments[j * count + w]);
                    prop_assert_eq!(bits(lane), bits(own), "{}: lane {} of {}", step, w, count);
                    prop_assert_eq!(&outcome[w], &own_outcome[0]);
                }
                x.iter_mut().zip(&increments).for_each(|(x, change)| *x += change);
            }
        }
    }

    /// One compiled method serves every choice of parameters: it agrees with methods compiled for
    /// the values as constants. Constants are rounded once where parameters are rounded in every
    /// product: a few dozen roundings of the increment.
    #[test]
    fn a_change_of_parameters_recompiles_nothing(
        inertias in vec((20..300_i32).prop_map(|v| f64::from(v) / 100.0), 3),
        x in state(3),
    ) {
        let body = library("rigid-body").system;
        let general = method(&body, 4, 6);
        let bracket = [("x1,x2", "-x3"), ("x2,x3", "-x1"), ("x3,x1", "-x2")];
        let order: Vec<&str> = body.parameters().iter().map(|p| p.name.as_str()).collect();
        prop_assert_eq!(&order, &["I1", "I2", "I3"]);
        for values in [body.parameter_values(), inertias] {
            let [a, b, c] = [values[0], values[1], values[2]];
            let hamiltonian = format!("x1^2/(2*{a}) + x2^2/(2*{b}) + x3^2/(2*{c})");
            let special = from_formulas(&["x1", "x2", "x3"], &[], &bracket, &hamiltonian, &[]);
            let special = method(&special, 4, 6);
            let sizes = (0.5, 0.1);
            let found = increment(&general, &values, sizes, &x).expect("a step");
            let expected = increment(&special, &[], sizes, &x).expect("a step");
            let error = distance(&found, &expected) / largest(&x);
            prop_assert!(error <= 50.0 * UNIT_ROUNDOFF, "{}: {:?} {:?}", error, found, expected);
        }
    }
}

/// The functions that a Newton iteration calls: the root of the guard over so3-exponential, two of a pair for each
/// coordinate over log-canonical; derivatives and orders add none.
#[test]
fn derivatives_and_orders_call_no_further_functions() {
    let registry = Registry::with_builtin();
    for (library, realization, initial, functions) in [
        ("rigid-body", "so3-exponential", "[1, 3, 3]", 1),
        (
            "lotka-volterra-periodic",
            "log-canonical",
            "[1, 1.9, 0.5]",
            6,
        ),
    ] {
        for order in [2, 4, 6] {
            let text = format!(
                "[system]\nlibrary = \"{library}\"\n[method]\nrealization = {{ name = \"{realization}\" }}\n\
                 dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = 0.05\n\
                 [run]\ninitial = {initial}\nsteps = 1\n"
            );
            let document = SceneDocument::parse("calls.toml", &text, &registry).expect("a scene");
            let run = leafwise::scene::compose(&document, &registry).expect("a method");
            let method = run.method.written().expect("a method written out");
            let newton = method.newton().expect("a step by Newton's iteration");
            let counts = [newton.operations(), newton.residual_operations()];
            assert_eq!(counts.map(|count| count.functions), [functions; 2]);
        }
    }
}
