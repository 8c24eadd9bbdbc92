//! Realizations and dynamic approximations over systems of numbers: the trajectories of formulas,
//! invariants to round-off, refusals of what needs formulas.

use std::sync::Arc;

use leafwise::core::diagnostics::measure_drift;
use leafwise::core::part::PartKind;
use leafwise::core::system::SystemInvariants;
use leafwise::core::{
    BuildError, DynamicApproximation, Method, PartParameters, PoissonSystem, RealizationData,
    Registry, StepMap, Walk,
};
use leafwise_tests::methods::run;
use leafwise_tests::{library, opaque};

fn collocated(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Registry::with_builtin()
        .realization("karasev-collocated")
        .and_then(|part| part.build(system, &PartParameters::new()))
        .expect("any system fits")
}

fn dynamics(name: &str, given: PartParameters) -> Arc<dyn DynamicApproximation> {
    Registry::with_builtin()
        .dynamics(name)
        .and_then(|part| part.build(&given))
        .expect("a dynamic approximation")
}

fn hamilton_jacobi(order: i64) -> Arc<dyn DynamicApproximation> {
    dynamics(
        "hamilton-jacobi",
        PartParameters::new().with("order", order),
    )
}

/// The method of order 2 in one solve, and by the generic path.
fn methods(system: &PoissonSystem) -> [Method; 2] {
    let fused = Method::compose(system, collocated(system), hamilton_jacobi(2));
    let generic = Method::compose_unfused(system, collocated(system), hamilton_jacobi(2));
    [fused, generic].map(|method| method.expect("the parts fit"))
}

/// As in `opaque_steppers`: round-off of a step times the growth of differences along an orbit.
const ROUND_OFF_A_STEP: f64 = 10.0 * 256.0 * f64::EPSILON;

const STEPS: usize = 100;

#[test]
fn numbers_and_formulas_give_the_same_trajectories() {
    for id in ["rigid-body", "lotka-volterra-periodic"] {
        let problem = library(id);
        let steps = |system: &PoissonSystem, map: &Method| {
            run(system, map, (0.1, 0.5), STEPS, &problem.initial)
                .unwrap_or_else(|error| panic!("{id}, {}: {error}", map.describe()))
        };
        let [reference, _] = methods(&problem.system);
        let expected = steps(&problem.system, &reference);
        for system in [
            opaque::with_derivatives(&problem.system),
            opaque::values_only(&problem.system),
        ] {
            for method in methods(&system) {
                for (found, expected) in steps(&system, &method).iter().zip(&expected) {
                    let error = (found - expected).abs() / expected.abs().max(1.0);
                    assert!(
                        error <= ROUND_OFF_A_STEP * STEPS as f64,
                        "{id}, {}: {found} against {expected}",
                        method.path()
                    );
                }
            }
        }
    }
}

#[test]
fn a_solve_by_values_has_the_same_bits_whatever_else_the_system_offers() {
    let problem = library("lotka-volterra-periodic");
    let states = [
        opaque::with_derivatives(&problem.system),
        opaque::values_only(&problem.system),
    ]
    .map(|system| {
        let [fused, _] = methods(&system);
        run(&system, &fused, (1.0, 0.1), STEPS, &problem.initial).expect("a run")
    });
    assert_eq!(states[0], states[1]);
}

#[test]
fn lanes_of_a_system_of_numbers_have_the_bits_of_single_trajectories() {
    let problem = library("rigid-body");
    let system = opaque::values_only(&problem.system);
    let [fused, _] = methods(&system);
    let values = system.parameter_values();
    let lanes = 3;
    let start = |lane: usize, i: usize| problem.initial[i] * (1.0 + 0.125 * lane as f64);
    let spread = |one: &[f64]| -> Vec<f64> {
        one.iter()
            .flat_map(|v| std::iter::repeat_n(*v, lanes))
            .collect()
    };
    let mut stepper = fused.stepper(lanes, &spread(&values), 1.0, 0.1);
    let x: Vec<f64> = (0..3 * lanes)
        .map(|at| start(at % lanes, at / lanes))
        .collect();
    let mut together = vec![0.0; x.len()];
    let mut outcome = vec![Ok(()); lanes];
    stepper.increment(&x, &vec![0.0; x.len()], &mut together, &mut outcome);
    for lane in 0..lanes {
        let own: Vec<f64> = (0..3).map(|i| start(lane, i)).collect();
        let mut alone = vec![0.0; 3];
        let mut single = [Ok(())];
        fused
            .stepper(1, &values, 1.0, 0.1)
            .increment(&own, &[0.0; 3], &mut alone, &mut single);
        assert_eq!((&outcome[lane], &single[0]), (&Ok(()), &Ok(())));
        for i in 0..3 {
            assert_eq!(together[i * lanes + lane], alone[i]);
        }
    }
}

/// A Casimir's round-off is that of its summands, up to 10 in size here: each step rounds the state
/// once more, and the errors add up like a random walk.
fn casimir_bound(steps: usize) -> f64 {
    16.0 * 10.0 * f64::EPSILON * libm::sqrt(steps as f64)
}

#[test]
fn casimirs_drift_by_round_off_alone() {
    let steps = 2000;
    for id in ["rigid-body", "lotka-volterra-periodic", "heavy-top"] {
        let problem = library(id);
        let system = opaque::values_only(&problem.system);
        let values = system.parameter_values();
        for method in methods(&system) {
            let mut walk = Walk::new(&method, &values, 1.0, 0.05, &problem.initial);
            let invariants = SystemInvariants::new(&system, &values).expect("code");
            let drifts = measure_drift(&mut walk, invariants, steps).expect("a run");
            for (name, drift) in system.casimir_names().iter().zip(&drifts[1..]) {
                assert!(
                    drift.largest <= casimir_bound(steps),
                    "{id}, {}, {name}: {:e}",
                    method.path(),
                    drift.largest
                );
            }
        }
    }
}

/// What every part says to a system of numbers; `None` where it serves it.
fn refusal(name: &str, kind: PartKind, system: &PoissonSystem) -> Option<BuildError> {
    let registry = Registry::with_builtin();
    let none = PartParameters::new();
    match kind {
        PartKind::Realization => {
            let given = match name {
                "darboux-magnetic" => none.with("potential", "0"),
                _ => none,
            };
            let part = registry.realization(name).expect("a realization");
            part.build(system, &given).err()
        }
        PartKind::Dynamics if name == "collective" => None,
        PartKind::Dynamics => {
            Method::compose(system, collocated(system), dynamics(name, none)).err()
        }
        PartKind::Stepper => {
            let part = registry.stepper(name).expect("a stepper");
            part.build(system, &none).err()
        }
        PartKind::System | PartKind::Composition => None,
    }
}

/// What refusals of systems of numbers name.
fn serving(registry: &Registry) -> String {
    let refused = BuildError::NotOffered {
        part: "acme/part",
        system: "test/numbers".to_owned(),
        missing: "formulas of the system",
    };
    let serving = registry.instead(&refused).expect("parts");
    assert!(serving.starts_with("what serves it: "), "{serving}");
    serving
}

#[test]
fn parts_that_need_formulas_say_so_and_what_serves_instead() {
    let system = opaque::with_derivatives(&library("rigid-body").system);
    let registry = Registry::with_builtin();
    for info in registry.parts() {
        let Some(error) = refusal(info.name, info.kind, &system) else {
            continue;
        };
        assert!(
            matches!(error, BuildError::NotOffered { .. }),
            "{}: {error}",
            info.name
        );
        assert_eq!(
            registry.explain(&error),
            format!(
                "{} needs formulas of the system, and test/numbers offers only numbers; {}",
                info.name,
                serving(&registry)
            )
        );
    }
}

#[test]
fn what_refusals_name_is_what_serves() {
    let system = opaque::with_derivatives(&library("rigid-body").system);
    let registry = Registry::with_builtin();
    let serving = serving(&registry);
    let words: Vec<&str> = serving
        .split(|c: char| !c.is_alphanumeric() && c != '-')
        .collect();
    for info in registry.parts() {
        if matches!(info.kind, PartKind::System | PartKind::Composition)
            || info.name == "collective"
        {
            continue;
        }
        let serves = refusal(info.name, info.kind, &system).is_none();
        assert_eq!(serves, words.contains(&info.name), "{}", info.name);
    }
}

#[test]
fn hamilton_jacobi_above_order_two_needs_formulas() {
    let system = opaque::values_only(&library("rigid-body").system);
    let refused = Method::compose(&system, collocated(&system), hamilton_jacobi(4))
        .expect_err("no formulas, no S_3");
    assert_eq!(
        refused.to_string(),
        "hamilton-jacobi needs formulas of the system for an order above 2, and test/values offers only numbers"
    );
}
