//! Observables that follow tangents along a run: indicators of chaos.

use leafwise_core::{PoissonSystem, Walk};
use leafwise_walk::Indicator;

use super::Refusal;
use super::dense::WRITTEN_LIMIT;
use super::observables::{Observable, indicator};
use super::stepping::Stepping;
use crate::document::{Located, SceneDocument};

/// The indicators among a scene's observables, in their order.
///
/// # Errors
/// A method whose steps offer no exact tangent, one with noise, and a long lattice.
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
    if method.lattice().is_some() {
        return refuse(
            format!(
                "`{name}` is not offered on a lattice of more than {WRITTEN_LIMIT} coordinates: it follows displacements by the \
                 derivative of every step, which couples all sites"
            ),
            "take a shorter lattice, or tangents in Python: `scene.trajectory().jvp`",
        );
    }
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
    if walk.advance(1).is_ok() && walk.tangent(0).is_none() {
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
