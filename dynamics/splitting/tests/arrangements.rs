//! The order of the pieces, and compositions that need pieces of a kind.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use crate::common::{Problem, distance, gauss, largest, library, run, splitting, step, toda};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::diagnostics::{TensorDefect, fit_slope};
use leafwise_core::solver::StepMap;
use leafwise_core::{BuildError, Convention, PartParameters, Pieces, PoissonSystem, Walk};

/// A system of two degrees of freedom.
fn canonical(id: &'static str, hamiltonian: &str, initial: &[f64]) -> Problem {
    let degrees = initial.len() / 2;
    let pairs = (1..=degrees).map(|i| (format!("q{i}"), format!("p{i}")));
    Problem {
        id,
        variables: ["q", "p"]
            .iter()
            .flat_map(|letter| (1..=degrees).map(move |i| format!("{letter}{i}")))
            .collect(),
        parameters: Vec::new(),
        bracket: pairs.map(|(q, p)| (q, p, "1".to_owned())).collect(),
        hamiltonian: hamiltonian.to_owned(),
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial: initial.to_vec(),
        time_step: 0.1,
    }
}

fn henon_heiles() -> Problem {
    let hamiltonian = "(p1^2 + p2^2)/2 + (q1^2 + q2^2)/2 + q1^2*q2 - q2^3/3";
    canonical("henon-heiles", hamiltonian, &[0.1, 0.3, 0.3, -0.2])
}

fn pendulum() -> Problem {
    canonical("pendulum", "p1^2/2 - cos(q1)", &[1.0, 0.5])
}

fn composed(system: &PoissonSystem, name: &str) -> Result<Composed, BuildError> {
    let base = splitting(system, &PartParameters::new())?;
    Composed::new(base, Scheme::find(name).expect("a scheme"))
}

/// The slope of the errors after `time`; errors under 20 ulps of the state are round-off.
fn order(problem: &Problem, map: &dyn StepMap, time: f64, steps: &[usize]) -> f64 {
    let system = problem.system();
    let exact = gauss(&system, &problem.initial, time, 200);
    let point = |steps: &usize| {
        let end = run(&system, map, &problem.initial, time, *steps).expect("finite");
        (
            time / *steps as f64,
            distance(&end, &exact) / largest(&exact),
        )
    };
    let points: Vec<(f64, f64)> = steps.iter().map(point).collect();
    let slope = fit_slope(&points, 20.0 * f64::EPSILON).expect("points above round-off");
    println!(
        "{}, {}: {} {points:?}",
        problem.id,
        map.describe(),
        slope.exponent
    );
    slope.exponent
}

/// The windows lie between errors of 1e-5 and 1e-13.
#[test]
fn compositions_for_momenta_and_positions_have_their_orders() {
    for (name, expected, steps) in [
        ("nystrom-4", 4, [32, 45, 64, 90, 128]),
        ("nystrom-6", 6, [7, 8, 10, 12, 14]),
        ("nystrom-6-long", 6, [7, 8, 10, 12, 14]),
    ] {
        for problem in [henon_heiles(), pendulum(), toda(4)] {
            let system = problem.system();
            let map = composed(&system, name).expect("the bracket is 0");
            assert_eq!(map.properties().order, expected);
            let measured = order(&problem, &map, 4.0, &steps);
            let error = (measured - expected as f64).abs();
            assert!(error < 0.5, "{name}, {}: {measured}", problem.id);
            let mut instrument = TensorDefect::new(&system, &map, &[], 1.0, 0.1).expect("a tensor");
            let defect = instrument.measure(&problem.initial).expect("finite");
            assert!(
                defect.norm <= 1e3 * f64::EPSILON * defect.scale,
                "{:e}",
                defect.norm
            );
        }
    }
}

/// By the pieces' errors alone, at equal cost.
#[test]
fn compositions_for_momenta_and_positions_err_less_than_those_for_any_pieces() {
    let problem = henon_heiles();
    let system = problem.system();
    let (time, flows) = (40.0, 2200.0);
    let exact = gauss(&system, &problem.initial, time, 2000);
    let error = |name: &str| {
        let stages = Scheme::find(name).expect("a scheme").stages() as f64;
        let map = composed(&system, name).expect("the bracket is 0");
        let steps = libm::round(flows / stages) as usize;
        let end = run(&system, &map, &problem.initial, time, steps).expect("finite");
        distance(&end, &exact)
    };
    let errors = [
        "nystrom-4",
        "blanes-moan-4",
        "nystrom-6-long",
        "blanes-moan-6",
    ]
    .map(error);
    println!("{errors:?}");
    assert!(errors[0] < errors[1] && errors[2] < errors[3], "{errors:?}");
}

/// Three pieces; and a bracket that is not 0: the rigid body's never ends.
#[test]
fn pieces_of_another_kind_are_refused_with_the_bracket() {
    for (id, words) in [
        ("lotka-volterra-periodic", "it has 3"),
        ("rigid-body", "{V, {V, {V, T}}} is not 0 for V = "),
    ] {
        let refusal = composed(&library(id).system(), "nystrom-6").err();
        let Some(BuildError::Pieces { asked, reason, .. }) = refusal else {
            panic!("{id}: {refusal:?}");
        };
        assert_eq!(asked, Pieces::Nystrom { kick_first: true });
        assert!(reason.contains(words), "{reason}");
    }
}

/// H = (p² + q²)/2 + ε q⁴, the oscillator one piece: a fixed step errs by ε² or ε³, so far as the conditions at ε hold. The larger piece
/// goes first, whatever order the splitting had.
#[test]
fn compositions_for_perturbations_err_by_powers_of_the_perturbation() {
    for (name, least) in [
        ("perturbed-8-2", 1.8),
        ("perturbed-10-4", 1.8),
        ("perturbed-8-6-4", 2.7),
        ("perturbed-10-6-4", 2.7),
    ] {
        let scheme = Scheme::find(name).expect("a scheme");
        let error = |epsilon: f64| {
            let hamiltonian = format!("(p1^2 + q1^2)/2 + {epsilon}*q1^4");
            let problem = canonical("oscillator", &hamiltonian, &[1.0, 0.3]);
            let system = problem.system();
            let (time, steps) = (20.0, 66);
            let [end, same] = ["1 2", "2 1"].map(|order| {
                let order = PartParameters::new().with("pieces", order);
                let base = splitting(&system, &order).expect("two pieces");
                let map = Composed::new(base, scheme).expect("two pieces");
                run(&system, &map, &problem.initial, time, steps).expect("finite")
            });
            assert_eq!(end, same, "{name}");
            distance(&end, &gauss(&system, &problem.initial, time, 2000))
        };
        let errors = [0.04, 0.02, 0.01].map(error);
        let slope = libm::log2(errors[0] / errors[2]) / 2.0;
        println!("{name}: {slope} {errors:?}");
        assert!(slope > least, "{name}: {slope} {errors:?}");
    }
}

/// χ in the order 2 1 is χ* in the order 1 2.
#[test]
fn the_order_of_the_pieces_is_a_choice() {
    let problem = library("lotka-volterra-periodic");
    let (system, h) = (problem.system(), 0.1);
    let values = system.parameter_values();
    let end = |order: &str, which: usize| {
        let map =
            splitting(&system, &PartParameters::new().with("pieces", order)).expect("an order");
        let [forwards, backwards] = map.abilities().factored.expect("factors").factors;
        let factor = [forwards, backwards][which].stepper(1, &values, 1.0, h);
        step({ factor }.as_mut(), &problem.initial).expect("finite")
    };
    assert_eq!(end("1 2 3", 0), end("3 2 1", 1));
    assert_ne!(end("1 2 3", 0), end("2 1 3", 0));
    for order in ["1 2", "1 2 2", "0 1 2", "first", "1 2 4", ""] {
        let refusal = splitting(&system, &PartParameters::new().with("pieces", order));
        assert!(
            matches!(refusal.err(), Some(BuildError::Parameter { parameter, .. }) if parameter == "pieces"),
            "{order}"
        );
    }
}

/// The periodic Lotka–Volterra orbit over 35 periods: the order of the costs errs by more than three times what another does, as
/// (790/644)⁶ = 3.4 of the steps that they need for one error; an order and its reverse err alike.
#[test]
fn another_order_errs_less() {
    let problem = library("lotka-volterra-periodic");
    let (system, time, steps) = (problem.system(), 100.0, 700);
    let exact = gauss(&system, &problem.initial, time, 8000);
    let error = |order: &str| {
        let base = splitting(&system, &PartParameters::new().with("pieces", order));
        let scheme = Scheme::find("blanes-moan-6").expect("a scheme");
        let map = Composed::new(base.expect("an order"), scheme).expect("factors");
        let end = run(&system, &map, &problem.initial, time, steps).expect("finite");
        distance(&end, &exact)
    };
    let [auto, best, reversed] = ["auto", "1 2 3", "3 2 1"].map(error);
    println!("{auto:e} {best:e} {reversed:e}");
    assert!(auto > 2.5 * best);
    assert!((reversed / best - 1.0).abs() < 0.1);
}

/// n steps in one call have the bits of n calls, and so have state, compensation and counts where a step fails.
#[test]
fn steps_in_one_call_are_those_one_by_one() {
    for name in ["blanes-moan-6", "kahan-li-8"] {
        let problem = library("heavy-top");
        let system = problem.system();
        let values = system.parameter_values();
        let map = composed(&system, name).expect("a composition");
        let start = |h: f64| Walk::new(&map, &values, 1.0, h, &problem.initial);
        let (mut one, mut many) = (start(0.1), start(0.1));
        for _ in 0..700 {
            one.step().expect("finite");
        }
        many.advance(300).expect("finite");
        many.advance(400).expect("finite");
        assert_eq!(one.checkpoint(), many.checkpoint());
        assert_eq!(one.statistics(), many.statistics());
    }
    let explosion = canonical("explosion", "p1^2/2 - q1^4", &[1.0, 1.0]);
    let system = explosion.system();
    let map = splitting(&system, &PartParameters::new()).expect("two pieces");
    let start = || Walk::new(map.as_ref(), &[], 1.0, 0.5, &explosion.initial);
    let (mut one, mut many) = (start(), start());
    let failure = (0..100).find_map(|_| one.step().err());
    assert_eq!(many.advance(100).err(), failure);
    assert!(failure.is_some());
    assert_eq!(one.checkpoint(), many.checkpoint());
    assert_eq!(one.statistics(), many.statistics());
}
