//! Steppers over systems of numbers: the same trajectories as over formulas.

use leafwise::core::{PartParameters, PoissonSystem, Registry, StepMap};
use leafwise_tests::methods::run;
use leafwise_tests::{library, opaque};
use std::sync::Arc;

/// The steppers that need only values, with their settings.
const STEPPERS: [(&str, &[(&str, i64)]); 8] = [
    ("rk4", &[]),
    ("dop853", &[]),
    ("dormand-prince45", &[]),
    ("implicit-midpoint", &[]),
    ("gauss", &[("stages", 3)]),
    ("energy-preserving", &[("order", 2)]),
    ("energy-preserving", &[("order", 4)]),
    ("projection", &[]),
];

fn build(
    name: &str,
    given: &[(&str, i64)],
    system: &PoissonSystem,
) -> Result<Arc<dyn StepMap>, String> {
    let parameters = given
        .iter()
        .fold(PartParameters::new(), |all, &(key, value)| {
            all.with(key, value)
        });
    let registry = Registry::with_builtin();
    let part = registry.stepper(name).expect("a built-in stepper");
    let built = part.build(system, &parameters);
    built.map_err(|error| registry.explain(&error))
}

/// Two ways to the same map differ by round-off of a few hundred operations a step; along these
/// bounded orbits of integrable systems a difference grows in proportion to time, here by less than
/// ten in all.
const ROUND_OFF_A_STEP: f64 = 10.0 * 256.0 * f64::EPSILON;

const STEPS: usize = 100;

#[test]
fn numbers_and_formulas_give_the_same_trajectories() {
    for id in ["rigid-body", "lotka-volterra-periodic"] {
        let problem = library(id);
        for (name, given) in STEPPERS {
            let reference = build(name, given, &problem.system).expect("formulas fit");
            let at = |map: &dyn StepMap, system: &PoissonSystem| {
                run(system, map, (1.0, 0.05), STEPS, &problem.initial)
                    .unwrap_or_else(|error| panic!("{id}, {name}: {error}"))
            };
            let expected = at(reference.as_ref(), &problem.system);
            for system in [
                opaque::with_derivatives(&problem.system),
                opaque::values_only(&problem.system),
            ] {
                let Ok(map) = build(name, given, &system) else {
                    assert_eq!(name, "projection", "it alone needs gradients of Casimirs");
                    continue;
                };
                let found = at(map.as_ref(), &system);
                for (found, expected) in found.iter().zip(&expected) {
                    let error = (found - expected).abs() / expected.abs().max(1.0);
                    assert!(
                        error <= ROUND_OFF_A_STEP * STEPS as f64,
                        "{id}, {name} {given:?}: {found} against {expected}, {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn projection_needs_the_gradients_of_the_casimirs() {
    let system = opaque::values_only(&library("rigid-body").system);
    let Err(refused) = build("projection", &[], &system) else {
        panic!("no gradients, no projection");
    };
    assert_eq!(
        refused,
        "projection needs the gradients of the Casimirs, and test/values offers only numbers; what \
         serves it: karasev-collocated with hamilton-jacobi of order 2 or with collective, and the \
         steppers rk4, dop853, dormand-prince45, implicit-midpoint, gauss, energy-preserving, projection"
    );
}
