//! Costs in counted operations: every built-in part counts its own, and counts what it does.

use std::sync::Arc;

use leafwise::core::SolverStatistics;
use leafwise::core::part::PartKind;
use leafwise::core::solver::NewtonKernel;
use leafwise::core::{BuildError, Method, PartParameters, Registry, StepMap, Walk};
use leafwise::verify::Problem;

const STEPS: u64 = 20;

fn of_kind(registry: &Registry, kind: PartKind) -> Vec<&'static str> {
    let parts = registry.parts().into_iter();
    parts.filter(|p| p.kind == kind).map(|p| p.name).collect()
}

fn pair(
    registry: &Registry,
    problem: &Problem,
    realization: &str,
    dynamics: &str,
) -> Result<Method, BuildError> {
    let none = PartParameters::new();
    let realization = registry
        .realization(realization)?
        .build(&problem.system, &none)?;
    let dynamics = registry.dynamics(dynamics)?.build(&none)?;
    Method::compose(&problem.system, realization, dynamics)
}

fn stepped(map: &dyn StepMap, problem: &Problem, steps: u64) -> Walk {
    let values = problem.system.parameter_values();
    let step = 0.1 * problem.time_step;
    let mut walk = Walk::new(map, &values, 1.0, step, &problem.initial);
    (0..steps).for_each(|_| walk.step().expect("a step"));
    walk
}

#[test]
fn every_built_in_map_counts_its_operations() {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    let mut counted = 0;
    for id in ["rigid-body", "lotka-volterra-periodic", "point-vortices"] {
        let problem = Problem::of_library(id).expect("a library system");
        let mut maps: Vec<Arc<dyn StepMap>> = Vec::new();
        for realization in of_kind(&registry, PartKind::Realization) {
            for dynamics in of_kind(&registry, PartKind::Dynamics) {
                let method = pair(&registry, &problem, realization, dynamics);
                maps.extend(method.map(|m| Arc::new(m) as Arc<dyn StepMap>));
            }
        }
        for stepper in of_kind(&registry, PartKind::Stepper) {
            let part = registry.stepper(stepper).expect("listed");
            maps.extend(part.build(&problem.system, &none));
        }
        for map in maps {
            let once = stepped(map.as_ref(), &problem, STEPS).statistics();
            let twice = stepped(map.as_ref(), &problem, 2 * STEPS).statistics();
            let name = map.describe();
            let (a, b) = (once.operations, twice.operations);
            let (a, b) = (
                a.unwrap_or_else(|| panic!("{name}")),
                b.expect("the same map"),
            );
            // At least the vector field once a step; and more steps, more operations.
            let field = problem
                .system
                .expressions()
                .expect("formulas")
                .vector_field_kernel()
                .expect("a field");
            assert!(a >= STEPS * field.step_operations().work(), "{name}: {a}");
            assert!(b > a, "{name}: {b} after {a}");
            counted += 1;
        }
    }
    assert!(counted > 30, "{counted} maps");
}

#[test]
fn a_newton_step_costs_its_evaluations_and_a_composition_its_stages() {
    let registry = Registry::with_builtin();
    let problem = Problem::of_library("rigid-body").expect("a library system");
    let method = pair(&registry, &problem, "so3-exponential", "hamilton-jacobi").expect("it fits");
    let statistics = stepped(&method, &problem, STEPS).statistics();
    let newton = method.newton().expect("both parts are code").clone();
    assert_newton_and_chords(&statistics, &newton, 1);

    let part = registry.composition("suzuki-4").expect("built in");
    let composed = part
        .build(Arc::new(method), &PartParameters::new())
        .expect("self-adjoint");
    let statistics = stepped(composed.as_ref(), &problem, STEPS).statistics();
    assert_newton_and_chords(&statistics, &newton, 5);
}

/// Every evaluation is one of Newton's, or one by a Jacobian that is there; every solve has a start.
fn assert_newton_and_chords(statistics: &SolverStatistics, newton: &NewtonKernel, solves: u64) {
    let (whole, chord) = (newton.work(), newton.chord_work());
    let operations = statistics.operations.expect("code is counted");
    let operations = operations - solves * statistics.steps * newton.start_work();
    let beyond = operations - statistics.evaluations * chord;
    assert_eq!(beyond % (whole - chord), 0, "{operations}");
    let jacobians = beyond / (whole - chord);
    assert!(
        (1..=statistics.evaluations).contains(&jacobians),
        "{jacobians}"
    );
}
