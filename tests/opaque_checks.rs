//! Instruments on systems of numbers: by the derivatives they offer, else by differences, with a floor.

use leafwise::core::diagnostics::{
    Inconsistency, TensorDefect, Verdict, check_casimir, check_jacobi, find_inconsistency,
};
use leafwise::core::system::{
    Derivatives, OpaqueSystem, SystemEvaluator, SystemFunction, SystemNumbers,
};
use leafwise::core::{PartParameters, PoissonSystem, Registry, StepError, StepMap};
use leafwise::systems::all;
use leafwise_tests::scenes::composed;
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{library, opaque};
use proptest::prelude::*;
use std::cell::Cell;
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
            let found = find_inconsistency(system, &values, &problem.initial);
            assert_eq!(found, None, "{}", entry.id);
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

/// What is wrong with the values of a system.
#[derive(Clone, Copy, Debug)]
enum Wrong {
    /// (1 + a)∇H.
    Gradient,
    /// ∇H with one derivative off by a part of all of them.
    OneDerivative(usize),
    /// Π + a s 1.
    Symmetric,
    /// (1 + a ln |p|) Πp.
    Nonlinear,
}

/// The values of another system, of which some are wrong by a part.
struct WrongEvaluator {
    right: Box<dyn SystemEvaluator>,
    wrong: Wrong,
    part: f64,
    /// The size of Π.
    size: f64,
}

fn magnitude(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.abs() }
}

impl SystemEvaluator for WrongEvaluator {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        self.right.evaluate(function, y, out)?;
        match (self.wrong, function) {
            (Wrong::Symmetric, SystemFunction::Tensor(v)) => {
                for (out, v) in out.iter_mut().zip(v) {
                    *out += self.part * self.size * v;
                }
            }
            (Wrong::Nonlinear, SystemFunction::Tensor(v)) => {
                let norm = libm::sqrt(v.iter().map(|v| v * v).sum::<f64>());
                let factor = 1.0 + self.part * libm::log(norm);
                out.iter_mut().for_each(|out| *out *= factor);
            }
            (Wrong::Gradient, SystemFunction::Gradient) => {
                out.iter_mut().for_each(|g| *g *= 1.0 + self.part);
            }
            (Wrong::OneDerivative(at), SystemFunction::Gradient) => {
                let at = at % out.len();
                let all: f64 = out
                    .iter()
                    .zip(y)
                    .map(|(g, y)| (g * magnitude(*y)).abs())
                    .sum();
                out[at] += self.part * all / magnitude(y[at]);
            }
            _ => {}
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

/// Of whatever is wrong by a hundredth or more, in whatever system of the library, it is said which function it is.
#[test]
fn values_of_no_poisson_system_are_found() {
    let ids: Vec<&str> = all().iter().map(|entry| entry.id).collect();
    let found = Cell::new(0);
    let wrongs = prop_oneof![
        Just(Wrong::Gradient),
        (0_usize..64).prop_map(Wrong::OneDerivative),
        Just(Wrong::Symmetric),
        Just(Wrong::Nonlinear),
    ];
    let config = ProptestConfig::with_cases(200);
    proptest!(config, |(id in 0..ids.len(), wrong in wrongs, part in 0.01_f64..1.0)| {
        let problem = library(ids[id]);
        let values = problem.system.parameter_values();
        let all = opaque::values_only(&problem.system);
        let right = all.opaque().expect("a system of numbers");
        let ones = vec![1.0; problem.initial.len()];
        let mut image = ones.clone();
        right.numbers.evaluator(&values).tensor(&problem.initial, &ones, &mut image).expect("values");
        let size = image.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let source = right.numbers.clone();
        let system: PoissonSystem = OpaqueSystem {
            numbers: SystemNumbers::new(Derivatives::default(), move |parameters| {
                Box::new(WrongEvaluator {
                    right: source.evaluator(parameters),
                    wrong,
                    part,
                    size: if size == 0.0 { 1.0 } else { size },
                })
            }),
            ..right.clone()
        }
        .into();
        let told = find_inconsistency(&system, &values, &problem.initial);
        let is_it = matches!(
            (wrong, &told),
            (Wrong::Gradient | Wrong::OneDerivative(_), Some(Inconsistency::Gradient { .. }))
                | (Wrong::Symmetric, Some(Inconsistency::Symmetric { .. }))
                | (Wrong::Nonlinear, Some(Inconsistency::Nonlinear { .. }))
        );
        prop_assert!(is_it, "{}: {wrong:?} by {part}, and {told:?}", ids[id]);
        let words = told.as_ref().map(|told| told.told(system.variables())).unwrap_or_default();
        prop_assert!(words.contains(" = "), "{words}");
        found.set(found.get() + 1);
    });
    assert!(found.get() >= 200, "{} cases", found.get());
}

/// Steps of a part of a coordinate's size lead across the poles between neighbours that stand far from 0: the gradient is that of H all
/// the same.
#[test]
fn poles_and_kinks_beside_a_state_are_no_inconsistency() {
    for pair in ["1/(q[i] - q[j])^2", "1/abs(q[i] - q[j])", "max(q[i], q[j])"] {
        let run = composed(&format!(
            "[system]\nfamilies = {{ q = 12, p = 12 }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, p[i]^2/2) + sum(i<j, {pair})\"\n[method]\nstepper = \"splitting\"\n\
             time-step = 0.01\n[run]\nsteps = 1\ninitial = {{ \"q[i]\" = \"100 + 1.1*i\", \"p[i]\" = 1 }}\n"
        ));
        let values = run.system.parameter_values();
        for system in as_numbers(&run.system) {
            let found = find_inconsistency(&system, &values, &run.plan.initial);
            assert_eq!(found, None, "{pair}");
        }
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
