//! Steps of one or two evaluations as one kernel each: to the bit what they are one evaluation after the other.

use leafwise::core::solver::{SolverStatistics, StepCheck, StepRecord};
use leafwise::core::{
    Method, PartParameters, PoissonSystem, Registry, StepError, StepMap, Stepper, two_sum,
};
use leafwise_tests::library;
use leafwise_tests::systems::from_formulas;
use proptest::prelude::*;

/// Refuses increments of the first coordinate that lead beyond an edge.
struct Edge(f64);

impl StepCheck for Edge {
    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        if x[0] + increment[0] > self.0 {
            outcome[0] = Err(StepError::LeftChart { ratio: 1.0 });
        }
    }
}

/// Where a trajectory stands after some steps.
#[derive(Debug, PartialEq)]
struct Standing {
    made: u64,
    outcome: Result<(), StepError>,
    /// The state, what it holds beyond a double, and the stepper's memory.
    bits: Vec<u64>,
    way: Way,
    work: SolverStatistics,
}

/// The state after each step, and the evaluations up to there.
type Way = Vec<(Vec<u64>, u64)>;

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|v| v.to_bits()).collect()
}

fn standing(
    way: Way,
    outcome: Result<(), StepError>,
    numbers: [&[f64]; 3],
    work: SolverStatistics,
) -> Standing {
    Standing {
        made: way.len() as u64,
        outcome,
        bits: bits(&numbers.concat()),
        way,
        work,
    }
}

/// Up to so many steps with a record: their way, and what ended them.
fn recorded(
    stepper: &mut dyn Stepper,
    steps: u64,
    [x, low, room]: [&mut [f64]; 3],
    check: &mut dyn StepCheck,
) -> (Way, Result<(), StepError>) {
    let (d, count) = (x.len(), steps as usize);
    let (mut states, mut evaluations) = (vec![f64::NAN; d * count], vec![7; count]);
    let mut record = StepRecord::new(&mut states, &mut evaluations, d);
    let (made, outcome) = stepper.advance(steps, x, low, room, Some(check), Some(&mut record));
    let way = states.chunks_exact(d).map(bits).zip(evaluations);
    (way.take(made as usize).collect(), outcome)
}

/// A method over systems of two and three coordinates.
fn method(system: &PoissonSystem, realization: &str, m: i64) -> Method {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    let realization = registry.realization(realization).expect("a built-in part");
    let dynamics = registry
        .dynamics("hamilton-jacobi")
        .expect("a built-in part");
    let dynamics = dynamics.build(&none.clone().with("order", m));
    Method::compose(
        system,
        realization.build(system, &none).expect("it fits"),
        dynamics.expect("an even order"),
    )
    .expect("a method")
}

/// Systems, realizations and initial states.
fn problems() -> Vec<(PoissonSystem, &'static str, Vec<f64>)> {
    let oscillator = from_formulas(
        &["q", "p"],
        &[("k", 0.7)],
        &[("q,p", "1")],
        "p^2/2 + q^2/2 + k*q^4/4",
        &[],
    );
    let predator = from_formulas(
        &["x", "y"],
        &[("a", 1.5)],
        &[("x,y", "x*y")],
        "x - a*ln(x) + y - ln(y)",
        &[],
    );
    let body = library("rigid-body");
    let species = library("lotka-volterra-periodic");
    let cyclic = library("may-leonard");
    vec![
        (oscillator, "constant", vec![0.3, 0.8]),
        (predator, "log-canonical", vec![1.2, 0.7]),
        (body.system.clone(), "so3-cayley", body.initial.clone()),
        (body.system, "so3-exponential", body.initial),
        (species.system, "log-canonical", species.initial),
        (cyclic.system, "log-canonical", cyclic.initial),
    ]
}

/// Steps by [`Stepper::advance`](leafwise::core::Stepper::advance), so many a call; by increments; and by increments of as
/// many lanes as no kernel of whole steps serves, each the same trajectory.
fn all_ways(
    method: &Method,
    parameters: &[f64],
    initial: &[f64],
    h: f64,
    calls: &[u64],
    edge: f64,
) -> [Standing; 3] {
    let d = initial.len();
    let mut stepper = method.stepper(1, parameters, 1.0, h);
    let (mut x, mut low, mut room) = (initial.to_vec(), vec![0.0; d], vec![0.0; d]);
    let (mut way, mut outcome) = (Vec::new(), Ok(()));
    for steps in calls {
        let mut edge = Edge(edge);
        let numbers = [&mut x[..], &mut low[..], &mut room[..]];
        let (more, ended) = recorded(&mut *stepper, *steps, numbers, &mut edge);
        way.extend(more);
        outcome = ended;
        if outcome.is_err() {
            break;
        }
    }
    let advanced = standing(
        way,
        outcome,
        [&x, &low, &stepper.memory()],
        stepper.statistics(),
    );
    let steps = calls.iter().sum();
    let increments = |lanes| by_increments(method, parameters, initial, h, (steps, edge), lanes);
    [advanced, increments(1), increments(8)]
}

/// The first of so many equal lanes, and its part of the work.
fn by_increments(
    method: &Method,
    parameters: &[f64],
    initial: &[f64],
    h: f64,
    (steps, edge): (u64, f64),
    lanes: usize,
) -> Standing {
    let d = initial.len();
    let repeated = |values: &[f64]| -> Vec<f64> {
        let rows = values.iter().map(|value| vec![*value; lanes]);
        rows.collect::<Vec<_>>().concat()
    };
    let mut stepper = method.stepper(lanes, &repeated(parameters), 1.0, h);
    let (mut x, mut low) = (initial.to_vec(), vec![0.0; d]);
    let mut increments = vec![0.0; d * lanes];
    let (mut way, mut outcome) = (Way::new(), vec![Ok(()); lanes]);
    while (way.len() as u64) < steps && outcome[0].is_ok() {
        stepper.increment(
            &repeated(&x),
            &repeated(&low),
            &mut increments,
            &mut outcome,
        );
        let increment: Vec<f64> = increments.iter().step_by(lanes).copied().collect();
        if outcome[0].is_ok() {
            Edge(edge).check(&x, &increment, &mut outcome[..1]);
        }
        if outcome[0].is_ok() {
            for i in 0..d {
                (x[i], low[i]) = two_sum(x[i], increment[i] + low[i]);
            }
            let evaluations = stepper.statistics().evaluations / lanes as u64;
            way.push((bits(&x), evaluations));
        }
    }
    let memory = stepper.memory();
    let memory = &memory[..memory.len() / lanes];
    let (work, lanes) = (stepper.statistics(), lanes as u64);
    let work = SolverStatistics {
        steps: work.steps / lanes,
        evaluations: work.evaluations / lanes,
        operations: work.operations.map(|operations| operations / lanes),
        failures: work.failures / lanes,
        rounded: work.rounded / lanes,
        ..work
    };
    standing(way, outcome.swap_remove(0), [&x, &low, memory], work)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// From steps that one evaluation solves to those that leave the chart; 600 are enough for machine code to take
    /// the interpreter's place.
    #[test]
    fn steps_at_once_are_those_of_one_evaluation_after_the_other(
        problem in 0_usize..6,
        m in prop::sample::select(vec![2_i64, 4, 6]),
        logarithm in -7.0..1.0_f64,
        factors in prop::array::uniform3(0.5..1.5_f64),
        calls in prop::collection::vec(1_u64..200, 1..6),
        edge in prop_oneof![Just(f64::INFINITY), 0.5..4.0_f64],
    ) {
        let (system, realization, initial) = problems().swap_remove(problem);
        let method = method(&system, realization, m);
        let initial: Vec<f64> = initial.iter().zip(factors).map(|(x, factor)| x * factor).collect();
        let h = libm::exp(logarithm);
        let [advanced, alone, in_lanes] =
            all_ways(&method, &system.parameter_values(), &initial, h, &calls, edge);
        prop_assert_eq!(&advanced, &in_lanes);
        prop_assert_eq!(alone, in_lanes);
    }
}

/// Refuses increments of one coordinate that lead beyond an edge, and reads no other.
struct Watched {
    coordinate: usize,
    edge: f64,
    /// How often it was asked.
    asked: u64,
}

impl StepCheck for Watched {
    fn reads(&self, coordinate: usize) -> bool {
        coordinate == self.coordinate
    }

    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        self.asked += 1;
        if x[self.coordinate] + increment[self.coordinate] > self.edge {
            outcome[0] = Err(StepError::LeftChart { ratio: 1.0 });
        }
    }
}

/// Of two oscillators that H does not couple the one that a check reads is asked for, and what it refuses is refused: at the
/// step, and to the bits, at which it is one step after the other.
#[test]
fn a_check_is_asked_of_the_parts_that_it_reads() {
    let system = from_formulas(
        &["q", "p", "r", "s"],
        &[],
        &[("q,p", "1"), ("r,s", "1")],
        "p^2/2 + q^2/2 + q^4/4 + s^2/2 - cos(r)",
        &[],
    );
    let method = method(&system, "constant", 4);
    let mut refused = 0;
    for coordinate in 0..4 {
        for edge in [f64::INFINITY, 0.35] {
            let steps = |each: u64, calls: u64| {
                let mut stepper = method.stepper(1, &[], 1.0, 0.1);
                let mut x = vec![0.3, 0.1, 0.2, -0.3];
                let (mut low, mut room) = (vec![0.0; 4], vec![0.0; 4]);
                let mut watched = Watched {
                    coordinate,
                    edge,
                    asked: 0,
                };
                let (mut way, mut outcome) = (Way::new(), Ok(()));
                for _ in 0..calls {
                    let numbers = [&mut x[..], &mut low[..], &mut room[..]];
                    let (more, ended) = recorded(&mut *stepper, each, numbers, &mut watched);
                    way.extend(more);
                    outcome = ended;
                    if outcome.is_err() {
                        break;
                    }
                }
                let end = bits(&[x, low].concat());
                ((way, outcome, end), watched.asked)
            };
            let (together, asked) = steps(500, 1);
            assert_eq!(together, steps(1, 500).0, "x{coordinate} below {edge}");
            refused += u32::from(together.1.is_err());
            if edge.is_infinite() {
                assert_eq!((together.0.len(), asked), (500, 500), "x{coordinate}");
            }
        }
    }
    assert!(refused > 0);
}

/// Every problem above has such steps at order 4, and they are made: nothing else is left to the kernels of one
/// evaluation than the first step.
#[test]
fn a_small_step_is_made_at_once() {
    for (system, realization, initial) in problems() {
        let method = method(&system, realization, 4);
        let names: Vec<&str> = method
            .abilities()
            .kernels
            .iter()
            .map(|(name, _)| *name)
            .collect();
        assert!(
            names.contains(&"step of one evaluation"),
            "{realization}: {names:?}"
        );
        let parameters = system.parameter_values();
        let infinite = f64::INFINITY;
        let [advanced, alone, in_lanes] =
            all_ways(&method, &parameters, &initial, 0.01, &[1000], infinite);
        assert_eq!(advanced, in_lanes, "{realization}");
        assert_eq!(alone, in_lanes, "{realization}");
        // The first step has no solution before it, and the second a start that is known.
        let most = 1000 + advanced.work.most_evaluations;
        assert!(
            advanced.work.evaluations <= most,
            "{realization}: {:?}",
            advanced.work
        );
    }
}
