//! Claims of stages in lanes.

use leafwise_expression::vector::RegisterWork;
use leafwise_expression::{AlgebraError, Arithmetic, Function, Graph, Rational};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

use super::lanes::Lanes;
use super::path::SMOOTH;
use super::solution::{FixedPoint, StageLanes, Start, Unsettled};
use super::stage_lanes;
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::runge_kutta::stages::{StageSolver, UNTIL_LANES};
use crate::runge_kutta::{SmoothMap, Tableau};

/// A pendulum that drives a spring: q̇ = p, ṗ = −sin q, u̇ = v, v̇ = −k u + q/3 of the parameter k.
fn field() -> SmoothMap {
    let mut graph = Graph::new();
    let [q, p, u, v] = [0, 1, 2, 3].map(|i| graph.input(i));
    let sine = graph.apply(Function::Sin, &q).expect("sin has code");
    let k = graph.parameter(0);
    let spring = graph.multiply(&k, &u);
    let pull = graph.negate(&sine);
    let force = graph.combine(&[(-Rational::one(), spring), (Rational::new(1, 3), q)]);
    SmoothMap::compile(graph, &[p, pull, v, force], 1, 4).expect("derivatives")
}

fn lanes<const W: usize>(stages: usize, stiffness: f64, time_step: f64) -> Lanes<W> {
    let field = field().evaluator(&[stiffness], 1.0, 1.0);
    let tableau = Tableau::gauss(stages);
    Lanes::new((field.at(), &tableau, time_step, 1, true)).expect("a field with code")
}

fn start(z: &[f64]) -> Start<'_> {
    Start {
        point: z,
        sizes: z,
        beside: &[],
    }
}

/// Registers and single numbers alike.
fn assert_bits<const W: usize>(stages: usize, z: &[f64; 4], time_step: f64) {
    let mut wide = lanes::<W>(stages, 2.0, time_step);
    let mut alone = lanes::<W>(stages, 2.0, time_step);
    let mut z = *z;
    for step in 0..5 {
        let (mut change, mut expected) = ([0.0; 4], [0.0; 4]);
        let solved = wide.solve(0, start(&z), &mut change);
        let by_one = alone.solve_by(0, start(&z), &mut expected, |solve| solve.run_alone());
        let evaluations =
            |solved: Result<FixedPoint, Unsettled>| solved.map(|s| s.evaluations).ok();
        let spent = evaluations(solved);
        assert!(step > 0 || spent.is_some());
        assert_eq!(spent, evaluations(by_one));
        assert_eq!(
            change.map(f64::to_bits),
            expected.map(f64::to_bits),
            "{stages}"
        );
        for (z, change) in z.iter_mut().zip(change) {
            *z += change;
        }
    }
}

proptest! {
    /// Newton's iteration finds the same stages, to the roundings that both make: each of the sums of s products of size
    /// at most |τF|, the state's own, and what the field makes of them over the step, |τDF| ≤ 2.
    #[test]
    fn the_solution_is_that_of_newtons_iteration(
        z in vec(0.5..2.0_f64, 4),
        signs in vec(any::<bool>(), 4),
        stages in SMOOTH..=Tableau::MOST_STAGES,
        time_step in 0.01..0.4_f64,
    ) {
        let pairs = z.iter().zip(signs);
        let mut z: Vec<f64> = pairs.map(|(z, minus)| if minus { -z } else { *z }).collect();
        let solver = |is_by_lanes: bool| {
            let field = field().evaluator(&[2.0], 1.0, 1.0);
            let solver = StageSolver::new(field, Tableau::gauss(stages), time_step, 1);
            if is_by_lanes { solver.by_lanes() } else { solver }
        };
        let (mut by_lanes, mut by_newton) = (solver(true), solver(false));
        for step in 0..4 {
            let (mut change, mut expected) = (vec![0.0; 4], vec![0.0; 4]);
            by_lanes.solve(&z, &mut change).expect("a contraction");
            prop_assert!(step > 0 || by_lanes.is_by_lanes[0]);
            by_newton.solve(&z, &mut expected).expect("a step");
            let size = z.iter().fold(1.0_f64, |most, z| most.max(z.abs()));
            for (a, b) in change.iter().zip(&expected) {
                prop_assert!((a - b).abs() <= 64.0 * f64::EPSILON * size, "{a:e}, {b:e}");
            }
            let tangents = [&mut by_lanes, &mut by_newton].map(|solver| {
                let seeds = nalgebra::DMatrix::identity(4, 4);
                solver.tangent(0, &seeds).expect("a tangent")
            });
            let apart = (&tangents[0] - &tangents[1]).amax();
            prop_assert!(apart <= 256.0 * f64::EPSILON * tangents[1].amax(), "{apart:e}");
            for (z, change) in z.iter_mut().zip(change) {
                *z += change;
            }
        }
    }

    #[test]
    fn bits_are_those_of_any_registers(
        z in prop::array::uniform4(0.5..2.0_f64),
        time_step in 0.01..0.4_f64,
    ) {
        assert_bits::<1>(1, &z, time_step);
        assert_bits::<2>(2, &z, time_step);
        assert_bits::<4>(3, &z, time_step);
        assert_bits::<8>(8, &z, time_step);
        assert_bits::<16>(11, &z, time_step);
    }
}

/// A stiff spring: |τDF| = 30. The plain iteration diverges, Newton's takes the step, and the next ones.
#[test]
fn what_does_not_contract_is_newtons() {
    let field = field().evaluator(&[90_000.0], 1.0, 1.0);
    let mut solver = StageSolver::new(field, Tableau::gauss(3), 0.1, 1).by_lanes();
    let mut change = vec![0.0; 4];
    solver
        .solve(&[1.0, 0.0, 1.0, 0.0], &mut change)
        .expect("a step");
    assert!(!solver.is_by_lanes[0] && solver.until_lanes[0] == UNTIL_LANES);
    let evaluations = solver
        .solve(&[1.0, 0.0, 1.0, 0.0], &mut change)
        .expect("a step");
    // The spring is linear: two evaluations for the solve, and two for each quarter of its path.
    assert!(
        solver.until_lanes[0] == UNTIL_LANES - 1 && evaluations <= 10,
        "{evaluations}"
    );
}

/// Where all corrections halve, DF is formed for a tangent alone. Formed before an evaluator was made or long after, it gives the
/// same bits.
#[test]
fn a_jacobian_is_formed_where_it_is_needed() {
    for stages in [4, 8] {
        for (stiffness, time_step, is_plain) in [(2.0, 0.05, true), (90_000.0, 0.1, false)] {
            let (own, formed) = (field(), field());
            assert_eq!(formed.kernels().len(), 2);
            let [mut solver, mut expected] = [&own, &formed].map(|map| {
                let field = map.evaluator(&[stiffness], 1.0, 1.0);
                StageSolver::new(field, Tableau::gauss(stages), time_step, 1).by_lanes()
            });
            assert!(formed.has_formed_jacobian() && !own.has_formed_jacobian());
            assert!(own.has_jacobian() && solver.has_tangent());
            let mut z = [0.3, 0.1, 1.0, 0.2];
            for _ in 0..20 {
                let mut changes = [[0.0; 4]; 2];
                for (solver, change) in [&mut solver, &mut expected].into_iter().zip(&mut changes) {
                    solver.solve(&z, change).expect("a step");
                }
                assert_eq!(changes[0].map(f64::to_bits), changes[1].map(f64::to_bits));
                z.iter_mut()
                    .zip(changes[0])
                    .for_each(|(z, change)| *z += change);
            }
            assert_eq!(
                own.has_formed_jacobian(),
                !is_plain,
                "{stages}, {stiffness}"
            );
            let seeds = nalgebra::DMatrix::identity(4, 4);
            let [own_tangent, tangent] =
                [&mut solver, &mut expected].map(|solver| solver.tangent(0, &seeds));
            assert!(own_tangent.is_some() && own_tangent == tangent);
            assert!(own.has_formed_jacobian());
        }
    }
}

/// A derivative that is longer than code may be is refused at building, or where that stops nothing when it is asked for.
#[test]
fn a_jacobian_that_is_too_long_is_refused() {
    // q ↦ q·sin q in a graph that has no room for more.
    let code = |most: usize| {
        let mut graph = Graph::limited(most);
        let q = graph.input(0);
        let sine = graph.apply(Function::Sin, &q).expect("sin has code");
        let product = graph.multiply(&q, &sine);
        (graph, product)
    };
    let (graph, product) = code(4);
    assert_eq!(graph.len(), 4);
    let refused = SmoothMap::compile(graph.clone(), std::slice::from_ref(&product), 0, 1);
    let too_long = AlgebraError::CodeTooLong { most: 4 };
    assert!(matches!(refused, Err(BuildError::Algebra(reason)) if reason == too_long));
    let map = SmoothMap::compile_unproven(graph, &[product], 0, 1);
    let (mut evaluator, mut out) = (map.evaluator(&[], 1.0, 1.0), [0.0]);
    assert_eq!(evaluator.values(&[2.0], &mut out), Ok(()));
    assert_eq!(out, [2.0 * libm::sin(2.0)]);
    assert_eq!(
        evaluator.jacobians(&[2.0], &mut out),
        Err(StepError::NoTangent)
    );
    // cos q, q cos q and their sum are three more: whether they fit is known when they are formed, at once.
    let (graph, product) = code(7);
    let map = SmoothMap::compile(graph, &[product], 0, 1).expect("a short derivative");
    assert!(map.has_formed_jacobian());
    map.evaluator(&[], 1.0, 1.0)
        .jacobians(&[2.0], &mut out)
        .expect("a slope");
    let expected = libm::sin(2.0) + 2.0 * libm::cos(2.0);
    assert!((out[0] - expected).abs() <= 4.0 * f64::EPSILON);
}

/// At τ|DF| = 3 of a rotation the corrections of three stages fall by more than 1/2: there is a solution, and nothing that
/// certifies it.
#[test]
fn what_contracts_slowly_is_newtons_too() {
    let field = field().evaluator(&[1.0], 1.0, 1.0);
    let mut solver = StageSolver::new(field, Tableau::gauss(3), 3.0, 1).by_lanes();
    let mut change = vec![0.0; 4];
    solver
        .solve(&[0.1, 0.05, 1.0, 0.3], &mut change)
        .expect("a step");
    assert!(!solver.is_by_lanes[0]);
}

/// A coordinate that rests and is driven is measured by what it comes to.
#[test]
fn what_begins_to_move_is_known_to_its_own_digits() {
    let mut stages = lanes::<8>(8, 2.0, 0.2);
    let mut change = [0.0; 4];
    // u is driven by q = 10⁻²⁰⁰ alone.
    let z = [1e-200, 0.0, 0.0, 0.0];
    assert!(stages.solve(0, start(&z), &mut change).is_ok());
    // u = t²/6 · 10⁻²⁰⁰ (1 + O(t²)).
    let expected = 0.04 / 6.0 * 1e-200;
    assert!((change[2] - expected).abs() < 0.02 * expected, "{change:?}");
    let mut small = lanes::<8>(8, 2.0, 0.2);
    let mut other = [0.0; 4];
    let far = z.map(|z| z * libm::exp2(600.0));
    assert!(small.solve(0, start(&far), &mut other).is_ok());
    // The pendulum is linear there: the same digits.
    let scale = libm::exp2(600.0);
    assert_eq!(change.map(|v| v * scale), other);
}

/// q̇ = p, ṗ = −V′(q) for V = −cos q, q⁴/4, (1 − e⁻ᵠ)², e^{2q}/4 − q/2.
fn body(potential: usize) -> SmoothMap {
    let mut graph = Graph::new();
    let [q, p] = [0, 1].map(|i| graph.input(i));
    let force = match potential {
        0 => {
            let sine = graph.apply(Function::Sin, &q).expect("code");
            graph.negate(&sine)
        }
        1 => {
            let square = graph.multiply(&q, &q);
            let cube = graph.multiply(&square, &q);
            graph.negate(&cube)
        }
        2 => {
            let minus = graph.negate(&q);
            let e = graph.apply(Function::Exp, &minus).expect("code");
            let square = graph.multiply(&e, &e);
            graph.combine(&[(Rational::new(2, 1), square), (Rational::new(-2, 1), e)])
        }
        4 => {
            let five = graph.scale(&Rational::new(5, 1), &q);
            let sine = graph.apply(Function::Sin, &five).expect("code");
            graph.negate(&sine)
        }
        _ => {
            let twice = graph.scale(&Rational::new(2, 1), &q);
            let e = graph.apply(Function::Exp, &twice).expect("code");
            let one = graph.one();
            graph.combine(&[(Rational::new(-1, 2), e), (Rational::new(1, 2), one)])
        }
    };
    SmoothMap::compile(graph, &[p, force], 0, 2).expect("derivatives")
}

/// Orbits of drawn potentials at steps of 0.1 to 5, in lanes and by Newton's iteration along its path from z: where lanes find
/// stages these are Newton's, and where steps are short they find some.
#[test]
fn stages_found_at_long_steps_are_those_of_the_path() {
    let bodies = [0, 1, 2, 3, 4].map(body);
    let drawn = (0..5_usize, vec(-1.5..1.5_f64, 2), 1..=8_usize, 0.1..5.0_f64);
    let mut runner = TestRunner::new_with_rng(
        ProptestConfig::default(),
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    );
    let (mut compared, mut refused) = (0, 0);
    for _ in 0..600 {
        let (potential, mut z, stages, time_step) =
            drawn.new_tree(&mut runner).expect("a case").current();
        let field = || bodies[potential].evaluator(&[], 1.0, 1.0);
        let tableau = Tableau::gauss(stages);
        let mut lanes = stage_lanes(field().at(), &tableau, time_step, 1, true).expect("code");
        for _ in 0..40 {
            let (mut change, mut expected) = (vec![0.0; 2], vec![0.0; 2]);
            let mut newton = StageSolver::new(field(), tableau.clone(), time_step, 1);
            if lanes.solve(0, start(&z), &mut change).is_err() {
                refused += 1;
                break;
            }
            if newton.solve(&z, &mut expected).is_err() {
                break;
            }
            compared += 1;
            for (a, b) in change.iter().zip(&expected) {
                assert!(
                    (a - b).abs() <= 1e-8,
                    "{potential}, {stages}, {time_step}, {z:?}: {change:?}, {expected:?}"
                );
            }
            z.iter_mut()
                .zip(&change)
                .for_each(|(z, change)| *z += change);
        }
    }
    assert!(compared >= 5000 && refused > 0, "{compared}, {refused}");
}
