//! Every key that a scene may have.

use super::{bracket, ensemble, method, run, scene, system};

/// The paths of the keys that the reader knows, as `run.record.every`: what a test of every field
/// has to cover. `*` stands for a name that the scene chooses; where that is all a table holds, such
/// as the values of parameters, or the parameters of a part, it is not among them. Nor are the keys
/// of a plugin's table, which holds words alone.
pub fn scene_keys() -> Vec<String> {
    let tables: [(&str, &[&str]); 11] = [
        ("", &scene::KEYS),
        ("system.", &system::KEYS),
        ("system.bracket.", &bracket::KINDS),
        ("method.", &method::KEYS),
        ("run.", &run::KEYS),
        ("run.record.", &run::RECORD_KEYS),
        ("ensemble.", &ensemble::KEYS),
        ("ensemble.initial.", &ensemble::DISTRIBUTIONS),
        ("ensemble.initial.", &ensemble::CENTER),
        ("ensemble.parameters.*.", &ensemble::WAYS),
        ("ensemble.record.", &ensemble::RECORD_KEYS),
    ];
    let keys = tables
        .iter()
        .flat_map(|(table, keys)| keys.iter().map(move |key| format!("{table}{key}")));
    keys.collect()
}
