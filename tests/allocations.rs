//! The step loop allocates nothing: neither a stepper nor the state's update nor an observer.

use std::sync::Arc;

use allocation_counter::measure;
use leafwise::core::gradient::{Plan, Trajectory, Way};
use leafwise::core::part::PartKind;
use leafwise::core::{Method, PartParameters, Registry, StepMap, Walk};
use leafwise::expression::Execution;
use leafwise::prelude::SceneDocument;
use leafwise::scene;
use leafwise::scene::compose::Stepping;
use leafwise_tests::{Problem, library};

/// Steps until histories are full.
const WARM_UP: usize = 40;

/// Times that collocation may add a node, where the orbit comes to a place that asks for it.
const NODES: usize = 8;

/// Steps that are watched.
const STEPS: usize = 50;

fn names(registry: &Registry, kind: PartKind) -> Vec<&'static str> {
    let parts = registry.parts().into_iter();
    parts.filter(|p| p.kind == kind).map(|p| p.name).collect()
}

/// Asserts that steps of one and of several trajectories allocate nothing.
fn assert_allocates_nothing(problem: &Problem, map: &dyn StepMap) {
    let parameters = problem.system.parameter_values();
    let step = 0.1 * problem.time_step;
    let windows = match map.describe().contains("as many nodes as needed") {
        true => NODES,
        false => 1,
    };
    let mut walk = Walk::new(map, &parameters, 1.0, step, &problem.initial);
    (0..WARM_UP).for_each(|_| walk.step().expect("a step"));
    let allocates_nothing = (0..windows).any(|_| {
        measure(|| (0..STEPS).for_each(|_| walk.step().expect("a step"))).count_total == 0
    });
    assert!(allocates_nothing, "{}", map.describe());

    let lanes = 11;
    let spread =
        |values: &[f64]| -> Vec<f64> { values.iter().flat_map(|v| vec![*v; lanes]).collect() };
    let mut stepper = map.stepper(lanes, &spread(&parameters), 1.0, step);
    let (mut x, low) = (
        spread(&problem.initial),
        spread(&vec![0.0; problem.initial.len()]),
    );
    let mut increment = low.clone();
    let mut outcome = vec![Ok(()); lanes];
    let mut steps = |count: usize| {
        for _ in 0..count {
            stepper.increment(&x, &low, &mut increment, &mut outcome);
            x.iter_mut()
                .zip(&increment)
                .for_each(|(x, change)| *x += change);
        }
    };
    steps(WARM_UP);
    let allocates_nothing = (0..windows).any(|_| measure(|| steps(STEPS)).count_total == 0);
    assert!(allocates_nothing, "{}, lanes", map.describe());
}

#[test]
fn no_stepper_allocates() {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    // Interpreted or compiled from the start: what changes on the way allocates once.
    for execution in [Execution::Interpreted, Execution::Compiled] {
        execution.set_default_of_process();
        let mut checked = 0;
        for id in [
            "rigid-body",
            "lotka-volterra-periodic",
            "heavy-top",
            "magnetic",
            "point-vortices",
        ] {
            let problem = library(id);
            let mut maps: Vec<Arc<dyn StepMap>> = Vec::new();
            for realization in names(&registry, PartKind::Realization) {
                let part = registry.realization(realization).expect("listed");
                let Ok(realization) = part.build(&problem.system, &none) else {
                    continue;
                };
                for dynamics in names(&registry, PartKind::Dynamics) {
                    let part = registry.dynamics(dynamics).expect("listed");
                    let dynamics = part.build(&none).expect("defaults");
                    let method = Method::compose(&problem.system, realization.clone(), dynamics);
                    maps.extend(method.map(|map| Arc::new(map) as Arc<dyn StepMap>));
                }
            }
            for stepper in names(&registry, PartKind::Stepper) {
                let part = registry.stepper(stepper).expect("listed");
                maps.extend(part.build(&problem.system, &none));
            }
            let composition = registry.composition("suzuki-4").expect("built in");
            let composed = maps.iter().map(|map| composition.build(map.clone(), &none));
            let composed: Vec<_> = composed.flatten().collect();
            maps.extend(composed);
            for map in maps {
                assert_allocates_nothing(&problem, map.as_ref());
                checked += 1;
            }
        }
        assert!(checked > 30, "{checked} maps");
    }
    lattices_and_observers();
}

/// A long lattice with its observers.
fn lattices_and_observers() {
    let text = "[system]\nlibrary = \"volterra-lattice\"\nfamilies = { x = 100 }\n\
                 [method]\nrealization = { name = \"karasev-truncated\", order = 2 }\n\
                 dynamics = { name = \"hamilton-jacobi\", order = 2 }\ntime-step = 0.05\n\
                 [run]\ninitial = { \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }\nsteps = 1\n";
    let document =
        SceneDocument::parse("lattice.toml", text, &Registry::with_builtin()).expect("a scene");
    let run = scene::compose(&document, &Registry::with_builtin()).expect("a method");
    let Stepping::Lattice(lattice) = &run.method else {
        panic!("a long lattice steps by templates");
    };
    let mut observers = lattice.invariants.clone();
    let mut values = vec![0.0; observers.observables()];
    let mut walk = run.walk();
    let mut steps = |count: usize| {
        for _ in 0..count {
            walk.step().expect("a step");
            observers.evaluate(walk.state(), &mut values);
        }
    };
    steps(WARM_UP);
    let counted = measure(|| steps(STEPS));
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

#[test]
fn an_allocation_is_counted() {
    let counted = measure(|| drop(std::hint::black_box(vec![1.0])));
    assert_eq!(counted.count_total, 1);
}

/// Steps back hold as many bytes at once for any number of steps, and checkpoints as many more as there are: 40 for 10³
/// steps, 68 for 10⁵.
#[test]
fn a_gradient_holds_as_much_for_a_hundred_times_the_steps() {
    let problem = library("rigid-body");
    let registry = Registry::with_builtin();
    let method = registry.automatic(&problem.system, 4).expect("a method");
    let parameters = problem.system.parameter_values();
    let at = Trajectory {
        map: &method,
        parameters: &parameters,
        epsilon: 1.0,
        h: problem.time_step,
        goes_on: &|| true,
    };
    for (way, factor) in [(Way::Back, 1.0), (Way::Checkpoints, 68.0 / 40.0)] {
        let held = |steps: u64| {
            let plan = Plan {
                steps,
                every: steps,
            };
            let reached = at.run(&problem.initial, plan).expect("a run");
            let cotangents = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0];
            let measured = measure(|| {
                at.pull(
                    &problem.initial,
                    &reached,
                    &cotangents,
                    plan,
                    (true, Some(way)),
                )
                .expect("a gradient");
            });
            measured.bytes_max as f64
        };
        // What compiles kernels is not measured.
        for (_, kernel) in method.abilities().kernels {
            kernel.workspace_for(1, Execution::Compiled);
        }
        // Kernels of the way back are compiled after as many evaluations, each within one of the first runs.
        let mut many = held(100_000);
        let settled = (0..20).any(|_| {
            let before = many;
            many = held(100_000);
            many == before
        });
        assert!(settled, "{way:?}: other bytes at every run");
        let few = held(1_000);
        assert!(many <= factor * few, "{way:?}: {few} and {many} bytes");
    }
}

/// Walks along a long chain and a box of spins take at most 100 bytes a coordinate.
#[test]
fn walks_on_long_lattices_take_a_hundred_bytes_a_coordinate() {
    let chain = "[system]\nfamilies = { q = 200000, p = 200000 }\nbracket = \"canonical\"\n\
                 hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^4/4)\"\n[method]\nstepper = \"splitting\"\n\
                 time-step = 0.05\n[run]\nsteps = 3\ninitial = { \"q[i]\" = \"sin(0.1*i)\", \"p[i]\" = 0 }\n";
    let spins = "[system]\nfamilies = { s = { components = [\"x\", \"y\", \"z\"], length = [48, 48, 48] } }\n\
                 bracket = { lie-algebra = \"so3\" }\n\
                 hamiltonian = \"-sum(i, j, k, dot(s[i,j,k], s[i+1,j,k] + s[i,j+1,k] + s[i,j,k+1]))\"\n\
                 [method]\nstepper = \"splitting\"\ntime-step = 0.05\n[run]\nsteps = 3\n\
                 initial = { \"s.x[i,j,k]\" = 0, \"s.y[i,j,k]\" = \"sin(i)\", \"s.z[i,j,k]\" = \"cos(i)\" }\n";
    for (text, coordinates) in [(chain, 400_000), (spins, 3 * 48 * 48 * 48)] {
        let run = leafwise_tests::scenes::composed(text);
        let counted = measure(|| {
            run.walk().advance(3).expect("steps");
        });
        let each = counted.bytes_max as f64 / f64::from(coordinates);
        // 40 and 46.
        assert!(each <= 100.0, "{each}");
    }
}

#[test]
fn observers_allocate_nothing() {
    let problem = library("heavy-top");
    let parameters = problem.system.parameter_values();
    let mut observer =
        leafwise::core::system::SystemInvariants::new(&problem.system, &parameters).expect("code");
    let mut values = vec![0.0; observer.observables()];
    let counted = measure(|| {
        (0..STEPS).for_each(|_| observer.evaluate(&problem.initial, &mut values));
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}
