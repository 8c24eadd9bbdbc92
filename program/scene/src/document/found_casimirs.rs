//! `casimirs = "find"`: the Casimirs of a scene's bracket in the place of the word.

use leafwise_core::Registry;
use leafwise_find::{corank, named_casimirs_of};
use toml::de::DeTable;

use super::equations::{FIND, has_equations, with_casimirs, with_plain_run};
use super::error::SceneProblemCause;
use super::located::Place;
use super::reader::{Problems, Table, end_of};
use super::scene::SceneDocument;
use crate::compose::compose_system;

/// The degree of the Casimirs that are looked for.
const DEGREE: usize = 2;

/// The text with the Casimirs that its bracket has, where it asks for them. A text whose other tables cannot be read stays, so that their errors are told.
pub(super) fn with_found_casimirs(
    name: &str,
    text: String,
    registry: &Registry,
    problems: &mut Problems,
) -> Option<String> {
    let Some(place) = asked_at(&text) else {
        return Some(text);
    };
    let parsed = with_casimirs(&text, &[])
        .and_then(|text| with_plain_run(&text, None, 1))
        .map_err(|_| ())
        .and_then(|plain| SceneDocument::parse(name, &plain, registry).map_err(|_| ()));
    let Ok(document) = parsed else {
        return Some(text);
    };
    let found = compose_system(&document)
        .map_err(|refusal| refusal.message)
        .and_then(|composed| {
            let system = composed.system.formulas("the search for Casimirs");
            let system = system.map_err(|error| error.to_string())?;
            let rows = named_casimirs_of(system, DEGREE).map_err(|error| error.to_string())?;
            match (rows.is_empty(), corank(system)) {
                (false, _) => Ok(rows),
                (true, 0) => {
                    Err("it has full rank, so that only constants commute with all".to_owned())
                }
                (true, _) => Err(format!(
                    "none has degree {DEGREE} or less in the variables, their logarithms and the functions in it"
                )),
            }
        });
    match found {
        Ok(rows) => with_casimirs(&text, &rows).ok(),
        Err(reason) => {
            problems.push(SceneProblemCause::NoCasimirs { reason }, place);
            None
        }
    }
}

/// Where `casimirs` of `[system]` is the word `find`, but beside equations, whose Casimirs are found with the bracket.
fn asked_at(text: &str) -> Option<Place> {
    // Most scenes do not ask.
    if !text.contains(FIND) {
        return None;
    }
    let document = DeTable::parse(text).ok()?;
    let mut none = Problems::default();
    let root = Table::new("the scene", document.get_ref(), end_of(text), text);
    let table = root
        .get("system")?
        .table("[system]", "a table", &mut none)?;
    let item = table.get("casimirs").filter(|item| item.is_word(FIND))?;
    (!has_equations(&table)).then(|| item.place())
}
