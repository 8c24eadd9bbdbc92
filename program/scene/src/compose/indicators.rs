//! Observables that follow tangents along a run: indicators of chaos.

use leafwise_core::{PoissonSystem, StepMap, Walk};
use leafwise_walk::Indicator;

use super::Refusal;
use super::observables::{Observable, asks_for_indicator, indicator};
use super::stepping::Stepping;
use crate::document::{Located, SceneDocument};

/// The indicators among a scene's observables, in their order.
///
/// # Errors
/// A method whose steps offer no exact tangent, and one with noise.
pub(super) fn indicators(
    document: &SceneDocument,
    observables: &[Observable],
    method: &Stepping,
    step: (f64, f64),
    (system, initial): (&PoissonSystem, &[f64]),
) -> Result<Vec<Indicator>, Refusal> {
    let pairs = document.run.record.observables.iter().zip(observables);
    let asked = pairs.filter(|(_, own)| matches!(own, Observable::Indicator { .. }));
    let asked: Vec<&Located<String>> = asked.map(|(asked, _)| &asked.formula).collect();
    let Some(first) = asked.first() else {
        return Ok(Vec::new());
    };
    let refuse = |message: String, help: &str| {
        let place = document.place_in_formula(first, 0..first.value.len());
        Err(Box::new(document.diagnostic(
            &place,
            message,
            "here",
            Some(help.to_owned()),
        )))
    };
    let name = &first.value;
    if method.noise().is_some() {
        return refuse(
            format!("`{name}` is not offered with noise: every step is of another map"),
            "remove the noise, or record `energy`",
        );
    }
    if document.method.exact_energy.is_some() {
        return refuse(
            format!(
                "`{name}` is not offered with `energy = \"exact\"`: each step takes different multiples of Casimirs, and follows no single flow"
            ),
            "remove `energy` from [method]: the energy of a Poisson map does not drift",
        );
    }
    let map = method.map();
    let (epsilon, h) = step;
    let mut walk = Walk::new(map, &system.parameter_values(), epsilon, h, initial);
    // Where the step fails nobody knows, and the run will say why.
    let is_without = walk.advance(1).is_ok() && walk.tangent(0).is_none();
    if is_without && !has_derivative(map, (&system.parameter_values(), initial), step) {
        return refuse(
            format!(
                "`{name}` follows the exact tangent of each step, which `{}` does not offer",
                map.describe()
            ),
            "take hamilton-jacobi over a realization in closed form, splitting, or a composition of one of them",
        );
    }
    Ok(asked
        .iter()
        .filter_map(|text| indicator(&text.value))
        .collect())
}

/// Whether the map has the derivative of its step from a state, without a matrix.
fn has_derivative(
    map: &dyn StepMap,
    (parameters, state): (&[f64], &[f64]),
    (epsilon, h): (f64, f64),
) -> bool {
    let mut step = map.differential(parameters, epsilon, h);
    let [low, mut increment, mut vector] = [0.0, 0.0, 1.0].map(|of| vec![of; state.len()]);
    let moved = step.step(state, &low, &mut increment);
    moved.and_then(|()| step.push(&mut vector, &[])).is_ok()
}

/// Whether a scene records an indicator.
pub(super) fn follows_tangents(document: &SceneDocument) -> bool {
    let mut recorded = document.run.record.observables.iter();
    recorded.any(|own| asks_for_indicator(&own.formula.value))
}
