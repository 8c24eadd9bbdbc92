//! Parts are told from those of another system, and never taken for them: on systems of the library.

use std::sync::Arc;

use leafwise::core::{
    MapProperties, Method, PartParameters, Registry, SolverStatistics, StepError, StepMap, Stepper,
};
use leafwise::scene::compose::{check_first_order, check_tensor};
use leafwise::systems;
use leafwise::verify::Problem;

/// Systems whose formulas are soon compiled.
const LARGEST: usize = 6;

fn problems() -> Vec<Problem> {
    let small = systems::all().iter().filter(|entry| {
        let dimension = entry.dimension().expect("an entry of the library");
        dimension <= LARGEST
    });
    small
        .map(|entry| Problem::of_library(entry.id).expect("a system of the library"))
        .collect()
}

const STEPPERS: [&str; 3] = ["rk4", "implicit-midpoint", "splitting"];
const REALIZATIONS: [&str; 3] = ["karasev-truncated", "constant", "log-canonical"];

/// The maps that serve a problem, with their names; realizations pass their check on the way.
fn maps(registry: &Registry, problem: &Problem) -> Vec<(&'static str, Arc<dyn StepMap>)> {
    let (system, defaults) = (&problem.system, PartParameters::new);
    let mut maps: Vec<(&'static str, Arc<dyn StepMap>)> = Vec::new();
    for name in STEPPERS {
        let part = registry.stepper(name).expect("a stepper");
        maps.extend(part.build(system, &defaults()).ok().map(|map| (name, map)));
    }
    for name in REALIZATIONS {
        let part = registry.realization(name).expect("a realization");
        let Ok(realization) = part.build(system, &defaults()) else {
            continue;
        };
        check_tensor(name, system, &realization, &problem.initial).expect("its own tensor");
        let dynamics = registry.dynamics("hamilton-jacobi").expect("dynamics");
        let dynamics = dynamics.build(&defaults().with("order", 2));
        let method = Method::compose(system, realization, dynamics.expect("order 2"));
        if let Ok(method) = method {
            maps.push((name, Arc::new(method)));
        }
    }
    maps
}

/// A map whose last coordinate moves by so many times as much.
struct Faster(Arc<dyn StepMap>, f64);

impl StepMap for Faster {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn properties(&self) -> MapProperties {
        self.0.properties()
    }
    fn describe(&self) -> String {
        "faster".to_owned()
    }
    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        Box::new(FasterStepper(
            self.0.stepper(lanes, parameters, epsilon, h),
            self.1,
        ))
    }
}

struct FasterStepper(Box<dyn Stepper>, f64);

impl Stepper for FasterStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        self.0.increment(x, low, increment, outcome);
        if let Some(last) = increment.last_mut() {
            *last *= self.1;
        }
    }
    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        self.0.tangent(lane)
    }
    fn restart(&mut self) {
        self.0.restart();
    }
    fn statistics(&self) -> SolverStatistics {
        self.0.statistics()
    }
    fn memory(&self) -> Vec<f64> {
        self.0.memory()
    }
    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        self.0.restore(memory)
    }
}

/// Every map begins as the flow does, and one that errs by one in a hundred in one coordinate does not,
/// unless that coordinate rests.
#[test]
fn a_map_belongs_to_its_own_system_alone() {
    let registry = Registry::with_builtin();
    for problem in problems() {
        let (system, near) = (&problem.system, problem.initial.as_slice());
        let values = system.parameter_values();
        let mut numbers = system.numbers().expect("formulas").evaluator(&values);
        let (mut gradient, mut field) = (vec![0.0; near.len()], vec![0.0; near.len()]);
        numbers.gradient(near, &mut gradient).expect("values");
        numbers.tensor(near, &gradient, &mut field).expect("values");
        let moves = field.last().is_some_and(|rate| *rate != 0.0);
        for (name, map) in maps(&registry, &problem) {
            for epsilon in [1.0, -0.25] {
                let fits = check_first_order(name, system, map.as_ref(), epsilon, near);
                assert_eq!(fits, Ok(()), "{name} on {}", problem.name);
                let wrong = Faster(Arc::clone(&map), 1.01);
                let wrong = check_first_order(name, system, &wrong, epsilon, near);
                assert_eq!(wrong.is_err(), moves, "{name} on {}", problem.name);
            }
        }
    }
}

/// A realization of so(3)* is none of another tensor of dimension 3, in whatever units.
#[test]
fn a_realization_belongs_to_its_own_tensor_alone() {
    let registry = Registry::with_builtin();
    let body = Problem::of_library("rigid-body").expect("a system of the library");
    let part = registry.realization("so3-cayley").expect("a realization");
    let cayley = part.build(&body.system, &PartParameters::new());
    let cayley = cayley.expect("it fits");
    let others = problems().into_iter().filter(|p| p.system.dimension() == 3);
    for problem in others.chain([body]) {
        let own = part.build(&problem.system, &PartParameters::new()).is_ok();
        for size in [1.0, 1e-12, 1e12] {
            let near: Vec<f64> = problem.initial.iter().map(|x| size * x).collect();
            let fits = check_tensor("so3-cayley", &problem.system, &cayley, &near);
            assert_eq!(
                fits.is_ok(),
                own,
                "{} times {size:e}: {fits:?}",
                problem.name
            );
        }
    }
}
