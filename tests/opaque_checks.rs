//! Instruments on systems of numbers: by the derivatives they offer, else by differences, with a floor.

use leafwise::core::diagnostics::{TensorDefect, Verdict, check_casimir, check_jacobi};
use leafwise::core::{PartParameters, PoissonSystem, Registry, StepError, StepMap};
use leafwise::systems::all;
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{library, opaque};
use std::sync::Arc;

/// The same system with derivatives and without.
fn as_numbers(system: &PoissonSystem) -> [PoissonSystem; 2] {
    [
        opaque::with_derivatives(system),
        opaque::values_only(system),
    ]
}

/// What differences of relative error 1e-11 leave of sums that cancel a thousandfold.
const WORST_FLOOR: f64 = 1e-8;

#[test]
fn library_systems_as_numbers_pass_every_check() {
    for entry in all() {
        let problem = library(entry.id);
        let values = problem.system.parameter_values();
        for (system, by_differences) in as_numbers(&problem.system).iter().zip([false, true]) {
            let casimirs = 0..system.casimir_names().len();
            let casimirs = casimirs.map(|at| check_casimir(system, at, &values, &problem.initial));
            let checks = casimirs.chain([check_jacobi(system, &values, &problem.initial)]);
            for check in checks {
                let check = check.expect("numbers need no algebra");
                let told = (entry.id, by_differences, &check);
                assert_eq!(check.verdict, Verdict::NumericallyZero, "{told:?}");
                assert_eq!(check.floor.is_some(), by_differences, "{told:?}");
                assert!(check.floor.unwrap_or(0.0) <= WORST_FLOOR, "{told:?}");
            }
        }
    }
}

/// Entries with no structure at all: the identity fails by as much as its terms are large.
fn not_poisson() -> PoissonSystem {
    let entries = [
        ("x1,x2", "x3*x4 + 0.3*x1"),
        ("x1,x3", "x5^2 - x2"),
        ("x1,x4", "x2*x3 + 1"),
        ("x1,x5", "x4"),
        ("x2,x3", "x1*x5"),
        ("x2,x4", "x3 - 2*x5"),
        ("x2,x5", "x1^2"),
        ("x3,x4", "x5 + x1*x2"),
        ("x3,x5", "x2 - x4"),
        ("x4,x5", "x3^2 + x1"),
    ];
    let names = ["x1", "x2", "x3", "x4", "x5"];
    from_formulas(&names, &[], &entries, "x1", &[("wrong", "x1*x2 + x3")])
}

#[test]
fn a_tensor_that_is_not_poisson_is_found_and_traced_to_a_triple() {
    let near = [0.7, -1.1, 0.4, 1.3, -0.6];
    for system in as_numbers(&not_poisson()) {
        let check = check_jacobi(&system, &[], &near).expect("numbers");
        assert_eq!(check.verdict, Verdict::Violated, "{check:?}");
        assert_eq!(check.worst.len(), 3);
        assert!(check.residual > 1e-2, "{check:?}");
        let wrong = check_casimir(&system, 0, &[], &near).expect("numbers");
        assert_eq!(wrong.verdict, Verdict::Violated, "{wrong:?}");
        assert_eq!(wrong.worst.len(), 1);
    }
}

#[test]
fn an_energy_is_no_casimir() {
    let problem = library("rigid-body");
    let formulas = problem.system.expressions().expect("formulas");
    let mut casimirs = formulas.casimirs().to_vec();
    casimirs.push(leafwise::core::system::Casimir {
        name: "energy".to_owned(),
        expression: formulas.hamiltonian().clone(),
    });
    let spin = casimirs.len() - 2;
    let system = PoissonSystem::new(
        formulas.variables().to_vec(),
        formulas.parameters().to_vec(),
        formulas.tensor().clone(),
        formulas.hamiltonian().clone(),
        casimirs,
        formulas.convention(),
    )
    .expect("a system");
    let values = system.parameter_values();
    for system in as_numbers(&system) {
        let verdict = |at| {
            let check = check_casimir(&system, at, &values, &problem.initial);
            check.expect("numbers").verdict
        };
        assert_eq!(verdict(spin), Verdict::NumericallyZero);
        assert_eq!(verdict(spin + 1), Verdict::Violated);
    }
}

fn stepper(system: &PoissonSystem, name: &str) -> Arc<dyn StepMap> {
    Registry::with_builtin()
        .stepper(name)
        .and_then(|part| part.build(system, &PartParameters::new()))
        .expect("a stepper")
}

/// rk4 is no Poisson map, implicit midpoint neither on a quadratic tensor: the defect is far above the
/// floor, and known exactly from the formulas.
#[test]
fn a_defect_by_differences_is_the_exact_one_within_its_floor() {
    for id in ["rigid-body", "lotka-volterra-periodic"] {
        let problem = library(id);
        let values = problem.system.parameter_values();
        for name in ["rk4", "implicit-midpoint"] {
            let measure = |system: &PoissonSystem, by_differences: bool| {
                let map = stepper(system, name);
                let mut instrument = TensorDefect::new(system, map.as_ref(), &values, 1.0, 0.1)
                    .expect("an instrument");
                if by_differences {
                    instrument.measure_by_differences(&problem.initial)
                } else {
                    instrument.measure(&problem.initial)
                }
            };
            let exact = measure(&problem.system, false).expect("an exact tangent");
            assert_eq!(exact.floor, None);
            let values_only = opaque::values_only(&problem.system);
            assert_eq!(measure(&values_only, false), Err(StepError::NoTangent));
            let found = measure(&values_only, true).expect("differences");
            let floor = found.floor.expect("a floor");
            assert!(
                (found.norm - exact.norm).abs() <= floor,
                "{id}, {name}: {:e} and {:e}, floor {floor:e}",
                found.norm,
                exact.norm
            );
            // Differences of relative error 1e-11, and the conditioning of DΦ Π DΦᵀ.
            assert!(floor <= 1e-9 * exact.scale, "{id}, {name}: {floor:e}");
            let with_derivatives = opaque::with_derivatives(&problem.system);
            let numeric = measure(&with_derivatives, false).expect("a tangent of numbers");
            let round_off = 256.0 * f64::EPSILON * exact.scale;
            assert!(
                (numeric.norm - exact.norm).abs() <= round_off,
                "{id}, {name}"
            );
        }
    }
}
