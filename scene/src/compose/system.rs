//! The Poisson system of a scene, with its initial state.

use leafwise_core::PoissonSystem;

use super::Refusal;
use super::initial::initial_state;
use super::instantiate::instantiate;
use super::names::check_names;
use super::observables::Observable;
use crate::document::SceneDocument;

/// The largest dimension of a lattice that is written out site by site.
pub const DENSE_LIMIT: usize = 24;

/// A scene's system and where it starts.
#[derive(Clone, Debug)]
pub struct ComposedSystem {
    /// (M, π, H) with Casimirs and parameters.
    pub system: PoissonSystem,
    /// x_0.
    pub initial: Vec<f64>,
    /// What the run records.
    pub observables: Vec<Observable>,
}

/// Reads the formulas of a scene.
///
/// # Errors
/// The first thing wrong, underlined in the scene.
pub fn compose_system(document: &SceneDocument) -> Result<ComposedSystem, Refusal> {
    check_names(document)?;
    let (system, observables) = system_of_families(document)?;
    let initial = initial_state(document)?;
    Ok(ComposedSystem {
        system,
        initial,
        observables,
    })
}

/// The system with its families written out at their true lengths, as long as that is short.
fn system_of_families(
    document: &SceneDocument,
) -> Result<(PoissonSystem, Vec<Observable>), Refusal> {
    let system = &document.system;
    let lengths: Vec<usize> = system
        .families
        .iter()
        .map(|(_, length)| length.value)
        .collect();
    if let (Some((name, _)), true) = (system.families.first(), system.dimension() > DENSE_LIMIT) {
        return Err(Box::new(document.diagnostic(
            &name.place(),
            format!(
                "lattices of more than {DENSE_LIMIT} sites are not integrated yet: this one has {}",
                system.dimension()
            ),
            "this family",
            Some("shorten it, for example with --set system.families.NAME=16".to_owned()),
        )));
    }
    let mut instantiated = instantiate(document, &lengths)?;
    let observables = std::mem::take(&mut instantiated.observables);
    let system = instantiated.system(document).map_err(|error| {
        document.diagnostic(
            &document.system.bracket.place(),
            error.to_string(),
            "here",
            None,
        )
    })?;
    Ok((system, observables))
}
