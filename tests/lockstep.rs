//! Trajectories in lockstep: to the bit what each does by itself, whatever the others need or fail at, and
//! with as many calls into a part of numbers as one of them makes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use leafwise::core::system::{OpaqueSystem, SystemEvaluator, SystemFunction, SystemNumbers};
use leafwise::core::{
    Method, PartParameters, PoissonSystem, Registry, StepError, StepMap, Stepper,
};
use leafwise_tests::library;
use leafwise_tests::opaque::{values_only, with_derivatives};
use proptest::prelude::*;

/// A system of numbers that counts its calls and is defined where x1 < `edge`.
struct WatchedEvaluator {
    inner: Box<dyn SystemEvaluator>,
    calls: Arc<AtomicU64>,
    edge: f64,
}

fn watched(system: &PoissonSystem, edge: f64) -> (PoissonSystem, Arc<AtomicU64>) {
    let calls = Arc::new(AtomicU64::new(0));
    let opaque = system.opaque().expect("a system of numbers");
    let (inner, counted) = (opaque.numbers.clone(), Arc::clone(&calls));
    let numbers = SystemNumbers::new(inner.derivatives, move |parameters| {
        Box::new(WatchedEvaluator {
            inner: inner.evaluator(parameters),
            calls: Arc::clone(&counted),
            edge,
        })
    });
    let system = OpaqueSystem {
        numbers,
        ..opaque.clone()
    };
    (system.into(), calls)
}

impl SystemEvaluator for WatchedEvaluator {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        match y.iter().step_by(3).find(|x| **x >= self.edge) {
            Some(x) => Err(StepError::LeftChart {
                ratio: x / self.edge,
            }),
            None => self.inner.evaluate(function, y, out),
        }
    }
    fn operations(&self) -> Option<u64> {
        self.inner.operations()
    }
}

/// The maps that step in lockstep, over a system of numbers that ends at x1 = `edge`.
fn maps(edge: f64) -> Vec<Arc<dyn StepMap>> {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    let formulas = library("rigid-body").system;
    let (whole, _) = watched(&with_derivatives(&formulas), edge);
    let (values, _) = watched(&values_only(&formulas), edge);
    let mut maps = Vec::new();
    for name in ["rk4", "gauss", "implicit-midpoint"] {
        for system in [&whole, &values] {
            let part = registry.stepper(name).expect("built in");
            maps.push(part.build(system, &none).expect("it serves numbers"));
        }
    }
    // Newton's method by both tangents; Anderson's acceleration without D²H; an end of the chart.
    for (name, system) in [
        ("so3-cayley", &whole),
        ("so3-group", &whole),
        ("so3-cayley", &values),
        ("karasev-truncated", &whole),
    ] {
        let part = registry.realization(name).expect("built in");
        let realization = part.build(&formulas, &none).expect("it fits");
        let dynamics = registry.dynamics("hamilton-jacobi").expect("built in");
        let dynamics = dynamics.build(&none).expect("order 2");
        let method = Method::compose(system, realization, dynamics).expect("a method");
        assert_eq!(method.path(), "evaluators");
        maps.push(Arc::new(method));
    }
    maps
}

/// A stepper and its states.
struct Going {
    stepper: Box<dyn Stepper>,
    x: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    outcome: Vec<Result<(), StepError>>,
}

impl Going {
    /// `states` and `parameters`, a row a lane.
    fn new(map: &dyn StepMap, states: &[[f64; 3]], parameters: &[[f64; 3]], h: f64) -> Self {
        let lanes = states.len();
        let rows = |values: &[[f64; 3]]| -> Vec<f64> {
            (0..3)
                .flat_map(|j| values.iter().map(move |row| row[j]))
                .collect()
        };
        let x = rows(states);
        Self {
            stepper: map.stepper(lanes, &rows(parameters), 1.0, h),
            low: x.iter().map(|x| 1e-17 * x).collect(),
            increment: vec![0.0; 3 * lanes],
            outcome: vec![Ok(()); lanes],
            x,
        }
    }

    /// A step; a lane that fails goes on from half its state.
    fn step(&mut self) {
        let lanes = self.outcome.len();
        self.stepper
            .increment(&self.x, &self.low, &mut self.increment, &mut self.outcome);
        for (at, x) in self.x.iter_mut().enumerate() {
            match self.outcome[at % lanes] {
                Ok(()) => *x += self.increment[at],
                Err(_) => *x *= 0.5,
            }
        }
    }

    fn lane(&self, lane: usize) -> [u64; 3] {
        let lanes = self.outcome.len();
        [0, 1, 2].map(|j| self.increment[j * lanes + lane].to_bits())
    }
}

fn bits(values: Option<Vec<f64>>) -> Option<Vec<u64>> {
    values.map(|values| values.iter().map(|v| v.to_bits()).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// States of every size need different numbers of iterations, and some leave the system's domain or
    /// the realization's chart.
    #[test]
    fn lanes_are_what_each_is_alone(
        states in proptest::collection::vec(proptest::array::uniform3(-2.0_f64..2.0), 2..20),
        other in 0_usize..20,
        h in 0.05_f64..0.6,
        edge in 0.8_f64..3.0,
    ) {
        // Two groups of lanes with their own parameters.
        let parameters: Vec<[f64; 3]> = (0..states.len())
            .map(|lane| if lane < other { [1.0, 0.75, 1.25] } else { [0.5, 2.0, 1.5] })
            .collect();
        for map in maps(edge) {
            let mut together = Going::new(map.as_ref(), &states, &parameters, h);
            let mut alone: Vec<Going> = states
                .iter()
                .zip(&parameters)
                .map(|(state, own)| Going::new(map.as_ref(), &[*state], &[*own], h))
                .collect();
            for step in 0..5 {
                together.step();
                alone.iter_mut().for_each(Going::step);
                for (lane, alone) in alone.iter_mut().enumerate() {
                    let place = format!("{}, step {step}, lane {lane}", map.describe());
                    prop_assert_eq!(&together.outcome[lane], &alone.outcome[0], "{}", place);
                    prop_assert_eq!(together.lane(lane), alone.lane(0), "{}", place);
                    if alone.outcome[0].is_err() {
                        continue;
                    }
                    let own = |stepper: &mut dyn Stepper, lane| {
                        (bits(stepper.solution(lane)), bits(stepper.tangent(lane)))
                    };
                    let (all, one) = (together.stepper.as_mut(), alone.stepper.as_mut());
                    prop_assert_eq!(own(all, lane), own(one, 0), "{}", place);
                }
            }
            let memory: Vec<f64> = alone.iter().flat_map(|own| own.stepper.memory()).collect();
            prop_assert_eq!(together.stepper.memory(), memory);
            let (all, own) = (
                together.stepper.statistics(),
                alone.iter().map(|own| own.stepper.statistics()).collect::<Vec<_>>(),
            );
            prop_assert_eq!(all.steps, own.iter().map(|own| own.steps).sum::<u64>());
            prop_assert_eq!(all.failures, own.iter().map(|own| own.failures).sum::<u64>());
            prop_assert_eq!(all.evaluations, own.iter().map(|own| own.evaluations).sum::<u64>());
            let most = own.iter().map(|own| own.most_evaluations).max();
            prop_assert_eq!(Some(all.most_evaluations), most);
            if all.failures == 0 {
                prop_assert_eq!(all.operations, own.iter().map(|own| own.operations).sum());
            }
        }
    }
}

/// A restored stepper goes on with the same bits.
#[test]
fn lanes_are_restored() {
    let states: Vec<[f64; 3]> = (0..5)
        .map(|lane| [0.3, 1.0 + 0.1 * f64::from(lane), -0.7])
        .collect();
    let parameters = [[1.0, 0.75, 1.25]; 5];
    for map in maps(9.0) {
        let mut going = Going::new(map.as_ref(), &states, &parameters, 0.2);
        (0..4).for_each(|_| going.step());
        let mut other = Going::new(map.as_ref(), &states, &parameters, 0.2);
        other.x.copy_from_slice(&going.x);
        let memory = going.stepper.memory();
        other.stepper.restore(&memory).expect("as long as its own");
        for _ in 0..3 {
            going.step();
            other.step();
            for lane in 0..5 {
                assert_eq!(going.lane(lane), other.lane(lane), "{}", map.describe());
            }
        }
        let shorter = &memory[..memory.len().saturating_sub(1)];
        if shorter.len() < memory.len() {
            assert_eq!(other.stepper.restore(shorter), Err(memory.len()));
        }
    }
}

/// Four evaluations of the field, of a gradient and a tensor each, for one lane and for sixteen; of gauss
/// from equal states as many as for one, from the second step on.
#[test]
fn a_batch_makes_as_many_calls_as_one_trajectory() {
    let registry = Registry::with_builtin();
    let (system, calls) = watched(&with_derivatives(&library("rigid-body").system), 9.0);
    let counted = |name: &str, lanes: usize| {
        let part = registry.stepper(name).expect("built in");
        let map = part.build(&system, &PartParameters::new());
        let map = map.expect("it serves numbers");
        let states = vec![[0.3, 1.0, -0.7]; lanes];
        let parameters = vec![[1.0, 0.75, 1.25]; lanes];
        let mut going = Going::new(map.as_ref(), &states, &parameters, 0.1);
        // Of the first step every lane's solution is confirmed by itself.
        going.step();
        calls.store(0, Ordering::Relaxed);
        going.step();
        assert_eq!(going.outcome, vec![Ok(()); lanes]);
        calls.load(Ordering::Relaxed)
    };
    assert_eq!(counted("rk4", 1), 8);
    assert_eq!(counted("rk4", 16), 8);
    assert_eq!(counted("gauss", 16), counted("gauss", 1));
}
