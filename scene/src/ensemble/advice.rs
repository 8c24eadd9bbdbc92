//! What to change in the scene of an ensemble.

use leafwise_core::Registry;

use super::plan::ComposedEnsemble;
use crate::advice::{Advice, MOST_STATES, advise, states_from};

/// Members at whose states the method is judged.
const JUDGED: u64 = 4;

/// What to change in the scene of an ensemble, judged at states of some of its members with the
/// scene's own parameters; see [`advise`].
pub fn advise_ensemble(ensemble: &ComposedEnsemble, registry: &Registry) -> Vec<Advice> {
    let members = ensemble.population.members();
    let judged = JUDGED.min(members);
    let each = MOST_STATES / JUDGED as usize;
    let states: Vec<Vec<f64>> = (0..judged)
        .filter_map(|k| {
            ensemble
                .population
                .draw((u128::from(k) * u128::from(members) / u128::from(judged)) as u64)
        })
        .flat_map(|(state, _)| states_from(&ensemble.run, &state, each))
        .collect();
    if states.is_empty() {
        return Vec::new();
    }
    advise(&ensemble.run, registry, &states)
}
