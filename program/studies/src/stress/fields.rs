//! Faults in every key of a scene.

use std::collections::BTreeSet;
use std::ops::Range;

use leafwise_core::Registry;
use leafwise_scene::document::{faults, scene_keys};
use leafwise_scene::{SceneDocument, Source, compose};

use super::case::{Case, Outcome, StressError, StressOptions, Tally};

pub(super) const CASES: [Case; 1] = [Case {
    family: "scene-fields",
    name: "keys",
    asked: "in every key that the reader knows, and in every numeric parameter of every registered part: nan, inf, -inf, \
            1e999, a number below the least, a fraction, an unknown word, an unknown key and a truth value, as the shape of \
            the key has it",
    expected: "no scene with a fault is taken, and each fault is refused at its place, where the same scene without it is \
               not; a key without a fault fails this case by its name",
    run: keys,
}];

/// Scenes that faults are written into, with a name for a variable or a parameter: a system that is written out, one of the
/// library, a lattice, equations.
pub const SCENES_FOR_FAULTS: [(&str, &str); 4] = [
    (include_str!("scenes/written-out.toml"), "a"),
    (include_str!("scenes/library.toml"), "a"),
    (include_str!("scenes/lattice.toml"), "\"a[i]\""),
    (include_str!("scenes/equations.toml"), "a"),
];

fn keys(_: &StressOptions) -> Result<Outcome, StressError> {
    let registry = Registry::with_builtin();
    for (scene, _) in SCENES_FOR_FAULTS {
        let document = SceneDocument::parse("case", scene, &registry)?;
        compose(&document, &registry).map_err(StressError::Refused)?;
    }
    let mut tally = Tally::default();
    let mut drawn = BTreeSet::new();
    for fault in faults(&registry) {
        let name = format!("{} = {}", fault.key, fault.written);
        let mut is_at_its_place = false;
        for (scene, own) in SCENES_FOR_FAULTS {
            let Some(said) = said_at(fault.within(scene, own), &registry) else {
                tally.take(false, || format!("{name} is taken"));
                continue;
            };
            if !is_at_its_place {
                let otherwise = said_at(fault.mended(scene, own), &registry).unwrap_or_default();
                is_at_its_place = said.iter().any(|message| !otherwise.contains(message));
            }
        }
        tally.take(is_at_its_place, || {
            format!("{name} is not refused at its place")
        });
        drawn.insert(fault.key);
    }
    let keys = scene_keys();
    for key in keys.iter().filter(|key| !drawn.contains(*key)) {
        tally.take(false, || format!("no fault in `{key}`"));
    }
    Ok(tally.outcome(|count| format!("{count} faults in {} keys refused", keys.len())))
}

/// Messages at a place of a scene that is refused; `None` where it is taken.
fn said_at((text, place): (String, Range<usize>), registry: &Registry) -> Option<Vec<String>> {
    let is_within = |span: &Range<usize>| place.start <= span.start && span.end <= place.end;
    match SceneDocument::parse("case", &text, registry) {
        Err(errors) => {
            let there = errors.problems.iter().filter(|problem| {
                problem.place.source == Source::Scene && is_within(&problem.place.span)
            });
            Some(there.map(ToString::to_string).collect())
        }
        Ok(document) => {
            let refusal = compose(&document, registry).err()?;
            let is_there = refusal.source_text == text && is_within(&refusal.span);
            Some(is_there.then_some(refusal.message).into_iter().collect())
        }
    }
}
