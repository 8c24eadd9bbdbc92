//! Scenes from their texts, with Casimirs in the place of `casimirs = "find"`.

use leafwise_core::Registry;
use leafwise_find::{corank, named_casimirs_of};

use crate::compose::compose_system;
use crate::document::{
    SceneDocument, SceneErrors, asking_for_casimirs, no_casimirs, with_casimirs, with_plain_run,
};

/// The degree of the Casimirs that are looked for.
const DEGREE: usize = 2;

impl SceneDocument {
    /// Reads a scene. Messages give `name`, the name of the file. The `registry` has the systems that the scene may
    /// name.
    ///
    /// # Errors
    /// Everything found wrong, with its place and the nearest valid name.
    pub fn parse(name: &str, text: &str, registry: &Registry) -> Result<Self, SceneErrors> {
        Self::parse_with(name, text, &[], registry)
    }

    /// Reads a scene after applying overrides such as `("method.epsilon", "0.05")`.
    ///
    /// An override rewrites the text, so that the scene as run can be saved and every place refers to it. A value that
    /// is not TOML is taken as a string. Setting one of several alternatives (`time-step` against `epsilon` and `h`,
    /// `stepper` against `realization` and `dynamics`, `ball` against `box`) removes the others. Casimirs that are found stand in the text too.
    ///
    /// # Errors
    /// Those of [`SceneDocument::parse`]. An override whose path the format does not have.
    pub fn parse_with(
        name: &str,
        text: &str,
        overrides: &[(String, String)],
        registry: &Registry,
    ) -> Result<Self, SceneErrors> {
        let Some(asking) = asking_for_casimirs(text, overrides) else {
            return Self::read_with(name, text, overrides, registry);
        };
        // Its errors are those of the text under the overrides.
        let shown = match overrides.is_empty() {
            true => name.to_owned(),
            false => format!("{name} with --set"),
        };
        match found(name, &asking, registry) {
            Some(Ok(text)) => Self::read_with(name, &text, &[], registry),
            Some(Err(reason)) => Err(no_casimirs(shown, asking, reason)),
            None => Self::read_with(name, &asking, &[], registry),
        }
    }
}

/// The text with the Casimirs of its bracket, or why there are none; `None` for a text whose other tables cannot be read, so that their errors are shown.
fn found(name: &str, text: &str, registry: &Registry) -> Option<Result<String, String>> {
    let plain = with_casimirs(text, &[]).and_then(|text| with_plain_run(&text, None, 1));
    let document = SceneDocument::read_with(name, &plain.ok()?, &[], registry).ok()?;
    let rows = compose_system(&document)
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
    Some(rows.and_then(|rows| with_casimirs(text, &rows).map_err(|error| error.to_string())))
}
