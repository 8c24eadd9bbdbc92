//! Direct sums: bodies, species and canonical pairs that H couples.

use std::fmt::Write;

use leafwise_core::{PoissonSystem, Walk};
use leafwise_expression::{Expression, Rational};
use leafwise_tests::gauss::flow;
use leafwise_tests::methods::run;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance};
use leafwise_tests::structure::structure_error;
use leafwise_tests::systems::from_formulas;
use proptest::collection::vec;
use proptest::prelude::*;

use super::common::gauss;

/// n bodies in a chain, each with its neighbour's spin in its energy.
fn bodies(n: usize) -> (PoissonSystem, Vec<f64>) {
    let mut variables = Vec::new();
    let mut bracket = Vec::new();
    let mut hamiltonian = String::from("0");
    let mut casimirs = Vec::new();
    let mut initial = Vec::new();
    for b in 0..n {
        let names = ["x", "y", "z"].map(|axis| format!("{axis}{b}"));
        for k in 0..3 {
            let [i, j, l] = [0, 1, 2].map(|at| &names[(k + at) % 3]);
            bracket.push((format!("{i},{j}"), format!("-{l}")));
            write!(
                hamiltonian,
                " + {}*{i}^2/2",
                1.0 / (0.8 + 0.2 * k as f64 + 0.01 * b as f64)
            )
            .expect("text");
            if b + 1 < n {
                let next = ["x", "y", "z"][k];
                write!(hamiltonian, " + {i}*{next}{}/10", b + 1).expect("text");
            }
        }
        let [x, y, z] = &names;
        casimirs.push((format!("spin{b}"), format!("{x}^2 + {y}^2 + {z}^2")));
        variables.extend(names.clone());
        let turned = b as f64;
        initial.extend([libm::cos(turned), 1.0 + 0.1 * libm::sin(turned), 0.7]);
    }
    let pairs = |list: &[(String, String)]| -> Vec<(String, String)> { list.to_vec() };
    let (bracket, casimirs) = (pairs(&bracket), pairs(&casimirs));
    fn of(list: &[(String, String)]) -> Vec<(&str, &str)> {
        list.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect()
    }
    let variables: Vec<&str> = variables.iter().map(String::as_str).collect();
    let system = from_formulas(&variables, &[], &of(&bracket), &hamiltonian, &of(&casimirs));
    (system, initial)
}

/// A heavy top whose support swings, with a species and a second body, in a mixed order.
fn mixed() -> (PoissonSystem, Vec<f64>) {
    let system = from_formulas(
        &[
            "u", "m1", "m2", "m3", "q", "g1", "g2", "g3", "v", "s1", "p", "s2", "s3",
        ],
        &[("a", 0.7)],
        &[
            ("m1,m2", "-m3"),
            ("m2,m3", "-m1"),
            ("m3,m1", "-m2"),
            ("m1,g2", "-g3"),
            ("m2,g3", "-g1"),
            ("m3,g1", "-g2"),
            ("m1,g3", "g2"),
            ("m2,g1", "g3"),
            ("m3,g2", "g1"),
            ("q,p", "-a"),
            ("u,v", "a*u*v"),
            ("s1,s2", "2*a*s3"),
            ("s2,s3", "2*a*s1"),
            ("s3,s1", "2*a*s2"),
        ],
        "m1^2/2 + m2^2/3 + m3^2/4 + g3*(1 + q/5) + p^2/2 + q^2/2 + u + v - ln(u) - ln(v) + s1^2/2 + s2^2/3 + s1*m1/5 + u*s3/7",
        &[
            ("square", "g1^2 + g2^2 + g3^2"),
            ("vertical", "m1*g1 + m2*g2 + m3*g3"),
            ("spin", "s1^2 + s2^2 + s3^2"),
        ],
    );
    let initial = vec![
        0.9, 0.5, 1.0, -0.4, 0.2, 0.6, 0.0, 0.8, 1.2, 0.3, -0.1, 0.8, -0.5,
    ];
    (system, initial)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Whatever couples them.
    #[test]
    fn any_coupling_keeps_the_structure(
        coupling in vec(-0.5..0.5_f64, 6),
        moved in vec(-0.2..0.2_f64, 13),
        stages in 1..=8_usize,
        time_step in 0.05..0.25_f64,
    ) {
        let (system, mut initial) = mixed();
        initial.iter_mut().zip(&moved).for_each(|(x, by)| *x += by);
        let formulas = system.expressions().expect("formulas");
        let products = [(0, 9), (1, 11), (4, 5), (6, 10), (3, 12), (8, 2)];
        let terms = products.iter().zip(&coupling).map(|((i, j), c)| {
            let c = Rational::from_f64(*c).expect("a number");
            Expression::Product(vec![
                Expression::Constant(c),
                Expression::Variable(*i),
                Expression::Variable(*j),
            ])
        });
        let all = std::iter::once(formulas.hamiltonian().clone()).chain(terms);
        let coupled = formulas.with_hamiltonian(Expression::Sum(all.collect()));
        let system = PoissonSystem::from(coupled.expect("a system"));
        let error = structure_error(&system, &gauss(&system, stages), time_step, &initial);
        let error = error.expect("a step");
        prop_assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{error:?}");
    }
}

#[test]
fn steps_of_sums_are_poisson_maps() {
    for ((system, initial), time_step) in [(bodies(3), 0.5), (mixed(), 0.25)] {
        for stages in [1, 2, 4, 8] {
            let method = gauss(&system, stages);
            let error = structure_error(&system, &method, time_step, &initial).expect("a step");
            assert!(error.tensor <= 64.0 && error.casimirs <= 64.0, "{error:?}");
        }
        let end = flow(&system, &initial, 2.0, 64);
        let found = run(&system, &gauss(&system, 8), (1.0, 0.2), 10, &initial).expect("steps");
        assert!(distance(&found, &end) <= 1e-12, "{found:?}, {end:?}");
    }
}

#[test]
fn a_resumed_sum_has_the_same_bits() {
    let (system, initial) = mixed();
    let method = gauss(&system, 8);
    let parameters = system.parameter_values();
    let start = || Walk::new(&method, &parameters, 1.0, 0.2, &initial);
    let (mut whole, mut resumed) = (start(), start());
    (0..20).for_each(|_| whole.step().expect("a step"));
    resumed
        .restore(&whole.checkpoint())
        .expect("its own checkpoint");
    for _ in 0..20 {
        whole.step().expect("a step");
        resumed.step().expect("a step");
        assert_eq!(whole.state(), resumed.state());
    }
}

/// Operations of an evaluation grow as the number of bodies, and every body keeps its spin.
#[test]
fn many_bodies_take_operations_in_proportion() {
    const STEPS: usize = 200;
    let mut operations = Vec::new();
    for n in [10, 50] {
        let (system, initial) = bodies(n);
        let method = gauss(&system, 8);
        let parameters = system.parameter_values();
        let mut walk = Walk::new(&method, &parameters, 1.0, 0.4, &initial);
        for _ in 0..STEPS {
            walk.step().expect("a step");
        }
        let x = walk.state();
        for (body, initial) in x.chunks_exact(3).zip(initial.chunks_exact(3)) {
            let [before, after] = [initial, body].map(|x| x.iter().map(|x| x * x).sum::<f64>());
            let wandered = 4.0 * libm::sqrt(STEPS as f64) * UNIT_ROUNDOFF;
            assert!((after / before - 1.0).abs() <= wandered, "{before} {after}");
        }
        let statistics = walk.statistics();
        let an_evaluation = statistics.operations.expect("kernels") / statistics.evaluations;
        operations.push(an_evaluation as f64);
    }
    assert!(operations[1] <= 5.5 * operations[0], "{operations:?}");
}
