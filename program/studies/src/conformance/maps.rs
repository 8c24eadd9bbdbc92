//! Step maps: by themselves, and those that a realization or a dynamic approximation makes.

use std::sync::Arc;

use leafwise_core::part::PartInfo;
use leafwise_core::{
    BuildError, Method, PartKind, PartParameters, RealizationData, Registry, StepMap, Structure,
    Walk,
};

use super::finding::{Finding, Place};
use super::parameters;
use crate::verify::{Judgement, Problem, measure};

/// Lanes that are stepped together, and steps of which every bit is compared.
const LANES: usize = 16;
const STEPS: usize = 20;

/// Orders are judged over so many of a problem's steps.
const HORIZON: f64 = 20.0;

/// A step map on every problem that it serves.
///
/// # Errors
/// [`BuildError`] where it is not in the registry.
pub(super) fn examine_stepper(
    registry: &Registry,
    part: &PartInfo,
    path: Option<&'static str>,
    problems: &[Problem],
    findings: &mut Vec<Finding>,
) -> Result<(), BuildError> {
    let stepper = registry.stepper(part.name)?;
    for problem in problems {
        if let Ok(map) = stepper.build(&problem.system, &parameters(part, path)) {
            let place = Place {
                path,
                problem: &problem.name,
            };
            examine(registry, place, "", problem, map.as_ref(), findings);
        }
    }
    Ok(())
}

/// Measures a dynamic approximation over realizations of every problem. The first of them is the first exact one that
/// fits, so that the bisection's own order is seen. The others are those whose points are not pairs (x, p).
///
/// # Errors
/// [`BuildError`] where it is not in the registry.
pub(super) fn examine_dynamics(
    registry: &Registry,
    part: &PartInfo,
    path: Option<&'static str>,
    problems: &[Problem],
    findings: &mut Vec<Finding>,
) -> Result<(), BuildError> {
    let offered = registry.dynamics(part.name)?;
    for problem in problems {
        let place = Place {
            path,
            problem: &problem.name,
        };
        let over = |name: &str| -> Option<Method> {
            let realization = registry.realization(name).ok()?;
            let realization = realization.build(&problem.system, &PartParameters::new());
            let dynamics = offered.build(&parameters(part, path));
            Method::compose(&problem.system, realization.ok()?, dynamics.ok()?).ok()
        };
        let exact = registry.exact_realizations().into_iter();
        let first = exact.filter_map(|(info, _)| over(info.name)).next();
        let parts = registry.parts().into_iter();
        let others = parts.filter(|part| !part.points_are_pairs);
        let others = others.filter_map(|part| over(part.name));
        for method in first.into_iter().chain(others) {
            let over = format!(" over {}", method.realization().describe());
            examine(registry, place, &over, problem, &method, findings);
        }
    }
    Ok(())
}

/// A realization under every dynamic approximation of the registry.
pub(super) fn under_dynamics(
    registry: &Registry,
    place: Place<'_>,
    problem: &Problem,
    realization: &Arc<dyn RealizationData>,
    findings: &mut Vec<Finding>,
) {
    let parts = registry.parts().into_iter();
    for part in parts.filter(|part| part.kind == PartKind::Dynamics) {
        let dynamics = registry.dynamics(part.name);
        let dynamics = dynamics.and_then(|part| part.build(&PartParameters::new()));
        let Ok(dynamics) = dynamics else {
            continue;
        };
        let under = format!(" under {}", dynamics.describe());
        if let Ok(method) = Method::compose(&problem.system, Arc::clone(realization), dynamics) {
            examine(registry, place, &under, problem, &method, findings);
        }
    }
}

/// Measures order, structure and symmetry of a step map against its declaration. Checks that every run and every lane
/// gives the same bits, as every map must.
fn examine(
    registry: &Registry,
    place: Place<'_>,
    with: &str,
    problem: &Problem,
    map: &dyn StepMap,
    findings: &mut Vec<Finding>,
) {
    let declared = map.properties();
    let horizon = HORIZON * problem.time_step;
    let named = |quantity: &str| format!("{quantity}{with}");
    let flow = match problem.flow(registry, horizon) {
        Ok(flow) => flow,
        Err(error) => {
            return findings.push(place.open(named("order"), error.to_string()));
        }
    };
    let measured = match measure(problem, map, (&flow, horizon), None) {
        Ok(measured) => measured,
        Err(error) => return findings.push(place.failed(named("steps"), &error)),
    };
    let [order, structure, symmetry] = measured.judgements;
    findings.push(place.order(
        named("order"),
        &declared.order.to_string(),
        (!measured.is_flow).then_some(measured.order),
        order,
    ));
    let is_round_off = structure == Judgement::Met
        && measured.structure.exponent.is_none()
        && measured.structure.at_least.is_none();
    match (declared.structure, measured.tensor_defect) {
        (Structure::Contact | Structure::None, _) => {}
        (Structure::Leaves, _) => {
            findings.push(place.judged(named("Casimirs"), measured.casimir_drift, structure))
        }
        (_, None) => findings.push(place.open(
            named("tensor defect"),
            "the map offers nothing to measure it by",
        )),
        // One step keeps the tensor, and an orbit of them does not.
        (Structure::Exact, Some(defect))
            if structure == Judgement::NotMet && measured.structure.exponent.is_none() =>
        {
            let worst = defect.max(measured.casimir_drift);
            let quantity = named("tensor and Casimirs along an orbit");
            findings.push(place.judged(quantity, worst, structure));
        }
        (kind, Some(_)) => findings.push(place.order(
            named("order of the tensor defect"),
            &match kind {
                Structure::Order(n) => n.to_string(),
                _ => "exact".to_owned(),
            },
            (!is_round_off).then_some(measured.structure),
            structure,
        )),
    }
    if declared.self_adjoint == Some(true) {
        let defect = measured.self_adjointness;
        findings.push(place.judged(named("its own adjoint"), defect, symmetry));
    }
    let t = measured.time_step;
    findings.push(place.holds(
        named("the same bits in every run"),
        repeats(problem, map, t),
    ));
    findings.push(place.holds(
        named(&format!("the same bits on {LANES} lanes")),
        lanes(problem, map, t),
    ));
}

/// Two orbits of the same map.
fn repeats(problem: &Problem, map: &dyn StepMap, t: f64) -> Option<String> {
    let values = problem.system.parameter_values();
    let orbit = || -> Vec<u64> {
        let mut walk = Walk::new(map, &values, 1.0, t, &problem.initial);
        let mut bits = Vec::new();
        let mut look = |walk: &Walk| bits.extend(walk.state().iter().map(|v| v.to_bits()));
        // An orbit ends where a step fails.
        let _ = walk.watch(STEPS as u64, &mut look);
        bits
    };
    (orbit() != orbit()).then(|| "two runs from one state differ".to_owned())
}

/// Lanes from neighbouring states against each of them alone, the first steps of all.
fn lanes(problem: &Problem, map: &dyn StepMap, t: f64) -> Option<String> {
    let values = problem.system.parameter_values();
    let d = problem.initial.len();
    let spread = |of: &dyn Fn(usize, usize) -> f64, length: usize| -> Vec<f64> {
        (0..length * LANES)
            .map(|at| of(at / LANES, at % LANES))
            .collect()
    };
    let state = |i: usize, lane: usize| problem.initial[i] * (1.0 + lane as f64 / 4096.0);
    let mut increment = vec![0.0; d * LANES];
    let mut outcome = vec![Ok(()); LANES];
    let parameters = spread(&|i, _| values[i], values.len());
    let mut together = map.stepper(LANES, &parameters, 1.0, t);
    let zero = vec![0.0; d * LANES];
    together.increment(&spread(&state, d), &zero, &mut increment, &mut outcome);
    (0..LANES).find_map(|lane| {
        let x: Vec<f64> = (0..d).map(|i| state(i, lane)).collect();
        let mut alone = vec![0.0; d];
        let mut own = [Ok(())];
        map.stepper(1, &values, 1.0, t)
            .increment(&x, &zero[..d], &mut alone, &mut own);
        let is_same = (0..d).all(|i| increment[i * LANES + lane].to_bits() == alone[i].to_bits());
        (!is_same || own[0].is_ok() != outcome[lane].is_ok())
            .then(|| format!("lane {lane} of {LANES} differs from the same state alone"))
    })
}
