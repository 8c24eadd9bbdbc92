//! A system by itself.

use leafwise_core::diagnostics::differences::{Differences, jacobian_by_differences};
use leafwise_core::diagnostics::{IdentityCheck, Verdict, check_casimir, check_jacobi};
use leafwise_core::part::PartInfo;
use leafwise_core::solver::judge::larger;
use leafwise_core::system::SystemEvaluator;
use leafwise_core::{BuildError, Registry, StepError};
use nalgebra::DMatrix;

use super::finding::{Finding, Place, worst};
use super::problems::{along, of_part};
use super::{parameters, paths};
use crate::verify::Problem;

/// Relative round-off allowed between two ways of computing the same numbers: 256·2⁻⁵², a few dozen roundings each, in
/// units of their size.
const ROUND_OFF: f64 = 256.0 * f64::EPSILON;

/// Examines a system on each of its paths, and the paths against each other.
///
/// # Errors
/// [`BuildError`] where the part cannot be built at its defaults.
pub(super) fn examine(
    registry: &Registry,
    part: &PartInfo,
    findings: &mut Vec<Finding>,
) -> Result<(), BuildError> {
    let system = registry.system(part.name)?;
    let mut problems = Vec::new();
    for path in paths(part) {
        let place = Place {
            path,
            problem: "itself",
        };
        match of_part(&system, &parameters(part, path))? {
            Some(problem) => {
                alone(registry, place, &problem, findings)?;
                problems.push(problem);
            }
            None => findings.push(place.open("states", "no state that was tried is in its domain")),
        }
    }
    if let [formulas, numbers] = problems.as_slice() {
        agreement(formulas, numbers, findings)?;
    }
    Ok(())
}

/// Identities, and derivatives of numbers, along an orbit.
fn alone(
    registry: &Registry,
    place: Place<'_>,
    problem: &Problem,
    findings: &mut Vec<Finding>,
) -> Result<(), BuildError> {
    let system = &problem.system;
    let values = system.parameter_values();
    let names = system.variables();
    let states = along(registry, problem);
    let mut identity =
        |quantity: String, check: &dyn Fn(&[f64]) -> Result<IdentityCheck, BuildError>| {
            let mut found = Vec::new();
            for near in &states {
                let check = check(near)?;
                let is_everywhere =
                    matches!(check.verdict, Verdict::Proved | Verdict::ByConstruction);
                found.push(place.identity(quantity.clone(), &check, names));
                if is_everywhere {
                    break;
                }
            }
            findings.extend(worst(found));
            Ok::<(), BuildError>(())
        };
    identity("Jacobi's identity".to_owned(), &|near| {
        check_jacobi(system, &values, near)
    })?;
    for (index, name) in system.casimir_names().into_iter().enumerate() {
        let check = |near: &[f64]| check_casimir(system, index, &values, near);
        identity(format!("Casimir {name}"), &check)?;
    }
    let Some(opaque) = system.opaque() else {
        return Ok(());
    };
    let mut evaluator = opaque.numbers.evaluator(&values);
    let offered = opaque.numbers.derivatives;
    let casimirs = system.casimir_names().len();
    let checks: [(&str, bool, Derivative); 4] = [
        ("gradient of H by differences", true, gradient),
        ("D(Pi v) by differences", offered.tensor, tensor_tangent),
        ("Hessian of H by differences", offered.hamiltonian, hessian),
        (
            "gradients of the Casimirs by differences",
            offered.casimirs && casimirs > 0,
            casimir_gradients,
        ),
    ];
    let mut counted = Counted {
        evaluator: evaluator.as_mut(),
        casimirs,
    };
    for (quantity, is_offered, derivative) in checks {
        if is_offered {
            let at = |near: &Vec<f64>| match derivative(&mut counted, near) {
                Ok((own, found)) => compared(place, quantity, &own, &found),
                Err(error) => place.failed(quantity, &error),
            };
            findings.extend(worst(states.iter().map(at)));
        }
    }
    Ok(())
}

/// An evaluator with the number of its system's Casimirs.
struct Counted<'a> {
    evaluator: &'a mut dyn SystemEvaluator,
    casimirs: usize,
}

/// A derivative as a system offers it, and the same by differences.
type Derivative = fn(&mut Counted<'_>, &[f64]) -> Result<(DMatrix<f64>, Differences), StepError>;

fn gradient(system: &mut Counted<'_>, y: &[f64]) -> Result<(DMatrix<f64>, Differences), StepError> {
    let evaluator = &mut *system.evaluator;
    let mut own = vec![0.0; y.len()];
    evaluator.gradient(y, &mut own)?;
    let found = jacobian_by_differences(y, 1, |at, out| evaluator.hamiltonian(at, out))?;
    Ok((DMatrix::from_row_slice(1, y.len(), &own), found))
}

fn tensor_tangent(
    system: &mut Counted<'_>,
    y: &[f64],
) -> Result<(DMatrix<f64>, Differences), StepError> {
    let (evaluator, d) = (&mut *system.evaluator, y.len());
    let v: Vec<f64> = (0..d).map(|i| 1.0 - 0.375 * (i % 5) as f64).collect();
    let own = columns(d, |unit, out| evaluator.tensor_tangent(y, &v, unit, out))?;
    let found = jacobian_by_differences(y, d, |at, out| evaluator.tensor(at, &v, out))?;
    Ok((own, found))
}

fn hessian(system: &mut Counted<'_>, y: &[f64]) -> Result<(DMatrix<f64>, Differences), StepError> {
    let (evaluator, d) = (&mut *system.evaluator, y.len());
    let own = columns(d, |unit, out| evaluator.hessian(y, unit, out))?;
    let found = jacobian_by_differences(y, d, |at, out| evaluator.gradient(at, out))?;
    Ok((own, found))
}

fn casimir_gradients(
    system: &mut Counted<'_>,
    y: &[f64],
) -> Result<(DMatrix<f64>, Differences), StepError> {
    let (evaluator, count) = (&mut *system.evaluator, system.casimirs);
    let mut own = vec![0.0; count * y.len()];
    evaluator.casimir_gradients(y, &mut own)?;
    let found = jacobian_by_differences(y, count, |at, out| evaluator.casimirs(at, out))?;
    Ok((DMatrix::from_row_slice(count, y.len(), &own), found))
}

/// The matrix whose columns a function of unit vectors gives.
fn columns(
    d: usize,
    mut column: impl FnMut(&[f64], &mut [f64]) -> Result<(), StepError>,
) -> Result<DMatrix<f64>, StepError> {
    let units = DMatrix::<f64>::identity(d, d);
    let mut matrix = DMatrix::zeros(d, d);
    for k in 0..d {
        let unit = units.column(k).into_owned();
        column(unit.as_slice(), matrix.column_mut(k).as_mut_slice())?;
    }
    Ok(matrix)
}

/// The largest difference in units of the largest entry, against what differences may be wrong by.
fn compared(place: Place<'_>, quantity: &str, own: &DMatrix<f64>, found: &Differences) -> Finding {
    let size = own.amax().max(found.jacobian.amax());
    let size = if size > 0.0 { size } else { 1.0 };
    let difference = (own - &found.jacobian).amax() / size;
    let bound = 2.0 * found.error.amax() / size + ROUND_OFF;
    place.at_most(quantity, difference, bound)
}

/// Formulas and functions of one part at the same state.
fn agreement(
    formulas: &Problem,
    numbers: &Problem,
    findings: &mut Vec<Finding>,
) -> Result<(), BuildError> {
    let place = Place {
        path: None,
        problem: "itself",
    };
    let y = numbers.initial.as_slice();
    let d = y.len();
    let values = |problem: &Problem| -> Result<Vec<(&'static str, Vec<f64>)>, StepError> {
        let system = &problem.system;
        let Ok(source) = system.numbers() else {
            return Ok(Vec::new());
        };
        let mut evaluator = source.evaluator(&system.parameter_values());
        let room = |n: usize| vec![0.0; n];
        let (mut tensor, mut energy, mut gradient) = (room(d), room(1), room(d));
        let mut casimirs = room(system.casimir_names().len());
        evaluator.gradient(y, &mut gradient)?;
        evaluator.tensor(y, &gradient, &mut tensor)?;
        evaluator.hamiltonian(y, &mut energy)?;
        if !casimirs.is_empty() {
            evaluator.casimirs(y, &mut casimirs)?;
        }
        Ok(vec![
            ("Pi grad H", tensor),
            ("H", energy),
            ("grad H", gradient),
            ("Casimirs", casimirs),
        ])
    };
    match (values(formulas), values(numbers)) {
        (Ok(formulas), Ok(numbers)) => {
            for ((name, a), (_, b)) in formulas.iter().zip(&numbers) {
                let size = a
                    .iter()
                    .chain(b)
                    .fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
                let off = a
                    .iter()
                    .zip(b)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, larger);
                let quantity = format!("{name} by functions and by formulas");
                findings.push(if a.len() == b.len() {
                    place.at_most(quantity, off / size, ROUND_OFF)
                } else {
                    let how = format!("{} numbers and {} formulas", b.len(), a.len());
                    place.holds(quantity, Some(how))
                });
            }
        }
        (Err(error), _) | (_, Err(error)) => {
            findings.push(place.failed("functions and formulas", &error));
        }
    }
    Ok(())
}
