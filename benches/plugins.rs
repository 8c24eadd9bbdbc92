//! What a step costs through a plugin, against the same part compiled in: the same operations, to the
//! same bits. Each pair is timed in turns, in one run; the ratio is that of the shortest turns.
//!
//! A part that hands over formulas becomes the same kernels as a built-in one. A part that hands over
//! functions is called through the C interface, for each evaluation of a single trajectory or for a
//! batch of lanes.

#![allow(clippy::print_stdout)]

#[path = "../plugins/loader/tests/support/build.rs"]
mod build;
#[path = "../plugins/loader/tests/support/twins.rs"]
mod twins;

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use leafwise::core::{
    Method, Part, PartParameters, PoissonSystem, RealizationData, Registry, StepMap, Stepper,
};
use leafwise::plugins::{LoadedPlugin, Loader, PluginRequest, SearchPath};
use leafwise::verify::Problem;

use build::{Workshop, rust_example};
use twins::{HeunTwin, RodriguesTwin, gyrostat_twin};

/// Lanes that are stepped together.
const LANES: [usize; 4] = [1, 16, 64, 256];

/// The step, and where lanes start: near one state, so that all do the same work.
const STEP: f64 = 0.1;
const START: [f64; 3] = [0.3, 1.0, -0.7];

/// How often each of a pair is timed, and for how long.
const TURNS: usize = 25;
const SECONDS: f64 = 0.01;

/// Trajectories that go on and on.
struct Going {
    stepper: Box<dyn Stepper>,
    state: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    outcome: Vec<Result<(), leafwise::core::StepError>>,
    steps: usize,
    best: f64,
}

impl Going {
    fn new(map: &dyn StepMap, parameters: &[f64], lanes: usize) -> Self {
        let spread = |values: &[f64]| -> Vec<f64> {
            let own = |value: &f64| std::iter::repeat_n(*value, lanes);
            values.iter().flat_map(own).collect()
        };
        let mut state = spread(&START);
        for (at, x) in state.iter_mut().enumerate() {
            *x *= 1.0 + (at % lanes) as f64 / 65536.0;
        }
        let mut going = Self {
            stepper: map.stepper(lanes, &spread(parameters), 1.0, STEP),
            low: vec![0.0; state.len()],
            increment: vec![0.0; state.len()],
            outcome: vec![Ok(()); lanes],
            state,
            steps: 16,
            best: f64::INFINITY,
        };
        let started = Instant::now();
        going.go(64);
        let one = started.elapsed().as_secs_f64() / 64.0;
        going.steps = ((SECONDS / one) as usize).max(4);
        going
    }

    fn go(&mut self, steps: usize) {
        for _ in 0..steps {
            self.stepper.increment(
                black_box(&self.state),
                &self.low,
                &mut self.increment,
                &mut self.outcome,
            );
            for (x, change) in self.state.iter_mut().zip(&self.increment) {
                *x += change;
            }
        }
        assert!(self.outcome.iter().all(Result::is_ok), "{:?}", self.outcome);
    }

    /// One more turn.
    fn turn(&mut self) {
        let started = Instant::now();
        self.go(self.steps);
        let one = started.elapsed().as_secs_f64() * 1e9 / (self.steps * self.outcome.len()) as f64;
        self.best = self.best.min(one);
    }
}

/// Times the same map compiled in and loaded, at every number of lanes.
fn pair(name: &str, parameters: &[f64], compiled_in: &dyn StepMap, loaded: &dyn StepMap) {
    println!("{name}");
    for lanes in LANES {
        let mut both = [compiled_in, loaded].map(|map| Going::new(map, parameters, lanes));
        for _ in 0..TURNS {
            both.iter_mut().for_each(Going::turn);
        }
        let [here, there] = &both;
        assert_eq!(here.state.len(), there.state.len());
        println!(
            "  {lanes:4} lanes: compiled in {:8.1} ns a step, loaded {:8.1} ns, ratio {:.3}",
            here.best,
            there.best,
            there.best / here.best
        );
    }
}

fn load(path: &Path, registry: &mut Registry) -> LoadedPlugin {
    let loader = Loader::new(SearchPath::default());
    let loaded = loader.load(&PluginRequest::new(path), Path::new("/"), registry);
    loaded.expect("a good plugin")
}

fn hamilton_jacobi(
    registry: &Registry,
    system: &PoissonSystem,
    realization: Arc<dyn RealizationData>,
) -> Method {
    let dynamics = registry.dynamics("hamilton-jacobi").expect("built in");
    let dynamics = dynamics.build(&PartParameters::new()).expect("order 2");
    Method::compose(system, realization, dynamics).expect("a method")
}

fn realizations(registry: &Registry, example: &LoadedPlugin) {
    let body = Problem::of_library("rigid-body")
        .expect("the rigid body")
        .system;
    let values = body.parameter_values();
    let part = registry
        .realization("example/so3-rodrigues")
        .expect("loaded");
    let on = |path: &str| {
        let path = PartParameters::new().with("path", path);
        part.build(&body, &path).expect("it fits")
    };
    let here = hamilton_jacobi(registry, &body, Arc::new(RodriguesTwin));
    let there = hamilton_jacobi(registry, &body, on("numbers"));
    pair(
        "a realization by functions (Rust), Hamilton-Jacobi of order 2",
        &values,
        &here,
        &there,
    );
    let mut declared = example.declaration.parts[0].clone();
    declared.description.name = "compiled-in".to_owned();
    declared.description.parameters.clear();
    declared.functions = None;
    let Part::Realization(own) = declared.part().expect("its formulas") else {
        unreachable!("a realization");
    };
    let own = own.build(&body, &PartParameters::new()).expect("it fits");
    let here = hamilton_jacobi(registry, &body, own);
    let there = hamilton_jacobi(registry, &body, on("expressions"));
    pair(
        "a realization by formulas, Hamilton-Jacobi of order 2",
        &values,
        &here,
        &there,
    );
}

fn systems(registry: &Registry) {
    let part = registry.system("example-c/gyrostat").expect("loaded");
    let loaded = part.build(&PartParameters::new()).expect("its defaults");
    let twin = gyrostat_twin(&loaded);
    let values = loaded.parameter_values();
    let collocated = |system: &PoissonSystem| {
        let part = registry
            .realization("karasev-collocated")
            .expect("built in");
        let realization = part.build(system, &PartParameters::new());
        hamilton_jacobi(registry, system, realization.expect("it serves numbers"))
    };
    pair(
        "a system by functions (C), collocation and Hamilton-Jacobi of order 2",
        &values,
        &collocated(&twin),
        &collocated(&loaded),
    );
    for name in ["rk4", "gauss"] {
        let stepper = registry.stepper(name).expect("built in");
        let on = |system: &PoissonSystem| {
            let map = stepper.build(system, &PartParameters::new());
            map.expect("it serves numbers")
        };
        pair(
            &format!("a system by functions (C), {name}"),
            &values,
            on(&twin).as_ref(),
            on(&loaded).as_ref(),
        );
    }
}

fn step_maps(registry: &Registry) {
    let body = Problem::of_library("rigid-body")
        .expect("the rigid body")
        .system;
    let part = registry.stepper("steps/heun").expect("loaded");
    let loaded = part.build(&body, &PartParameters::new().with("weight", 0.25));
    pair(
        "a step map by functions (C) that calls the program's system back, Heun's rule",
        &body.parameter_values(),
        &HeunTwin(body.clone()),
        loaded.expect("it fits").as_ref(),
    );
}

fn main() {
    let workshop = Workshop::new();
    let mut registry = Registry::with_builtin();
    let example = load(&rust_example(), &mut registry);
    load(
        &workshop.compile("../../../examples/c/gyrostat"),
        &mut registry,
    );
    load(&workshop.compile("steps"), &mut registry);
    realizations(&registry, &example);
    systems(&registry);
    step_maps(&registry);
}
