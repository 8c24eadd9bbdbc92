//! What a step costs through a plugin, against the same part compiled in: the same steps from the same
//! states, to the same bits. Each pair is timed in turns, in one run; times are the medians of the
//! turns, and so is the ratio of each turn's two.
//!
//! A part that hands over formulas becomes the same kernels as a built-in one. A part that hands over
//! functions is called through the C interface, for each evaluation of a single trajectory or for a
//! batch of lanes.
//!
//! `cargo bench -p leafwise-benches --bench plugins -- rk4` runs the pairs with that in their names.

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
const TURNS: usize = 201;
const NANOSECONDS: f64 = 5e5;

/// Steps before the first turn, and the most of a turn: Heun's rule leaves every region in time.
const WARM_UP: usize = 200;
const MOST_STEPS: usize = 4000;

/// Trajectories that start anew in every turn.
struct Going {
    stepper: Box<dyn Stepper>,
    start: Vec<f64>,
    state: Vec<f64>,
    low: Vec<f64>,
    increment: Vec<f64>,
    outcome: Vec<Result<(), leafwise::core::StepError>>,
}

impl Going {
    fn new(map: &dyn StepMap, parameters: &[f64], lanes: usize) -> Self {
        let spread = |values: &[f64]| -> Vec<f64> {
            let own = |value: &f64| std::iter::repeat_n(*value, lanes);
            values.iter().flat_map(own).collect()
        };
        let mut start = spread(&START);
        for (at, x) in start.iter_mut().enumerate() {
            *x *= 1.0 + (at % lanes) as f64 / 65536.0;
        }
        Self {
            stepper: map.stepper(lanes, &spread(parameters), 1.0, STEP),
            state: start.clone(),
            low: vec![0.0; start.len()],
            increment: vec![0.0; start.len()],
            outcome: vec![Ok(()); lanes],
            start,
        }
    }

    /// Nanoseconds for one step of one lane, over `steps` steps from the start.
    fn turn(&mut self, steps: usize) -> f64 {
        self.stepper.restart();
        self.state.copy_from_slice(&self.start);
        let started = Instant::now();
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
        let taken = started.elapsed().as_secs_f64() * 1e9;
        assert!(self.outcome.iter().all(Result::is_ok), "{:?}", self.outcome);
        taken / (steps * self.outcome.len()) as f64
    }
}

fn bits(state: &[f64]) -> Vec<u64> {
    state.iter().map(|x| x.to_bits()).collect()
}

/// The middle of these numbers.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Times the same map compiled in and loaded, at every number of lanes.
fn pair(name: &str, parameters: &[f64], compiled_in: &dyn StepMap, loaded: &dyn StepMap) {
    let mut wanted = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
        .peekable();
    if wanted.peek().is_some() && !wanted.any(|word| name.contains(&word)) {
        return;
    }
    println!("{name}");
    for lanes in LANES {
        let mut here = Going::new(compiled_in, parameters, lanes);
        let mut there = Going::new(loaded, parameters, lanes);
        let one = here.turn(WARM_UP).min(there.turn(WARM_UP)) * lanes as f64;
        let steps = ((NANOSECONDS / one) as usize).clamp(4, MOST_STEPS);
        let mut times = [Vec::new(), Vec::new(), Vec::new()];
        for turn in 0..TURNS {
            let [first, second] = if turn % 2 == 0 {
                [&mut here, &mut there].map(|going| going.turn(steps))
            } else {
                let [there, here] = [&mut there, &mut here].map(|going| going.turn(steps));
                [here, there]
            };
            times[0].push(first);
            times[1].push(second);
            times[2].push(second / first);
        }
        assert_eq!(bits(&here.state), bits(&there.state), "the same bits");
        let [first, second, ratio] = times.map(median);
        println!(
            "  {lanes:4} lanes: compiled in {first:8.1} ns a step, loaded {second:8.1} ns, ratio {ratio:.3}",
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
