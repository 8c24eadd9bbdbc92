//! A `[system]` table by itself.

use leafwise_core::{PoissonSystem, Registry};

use super::geometry::geometry;
use super::instantiate;
use crate::diagnostic::SceneDiagnostic;
use crate::document::SceneDocument;

/// The system of a fragment, the text of a `[system]` table that needs no library.
///
/// # Errors
/// The key in the table and what is wrong with it.
pub fn system_of_fragment(id: &str, fragment: &str) -> Result<PoissonSystem, (String, String)> {
    let of_scene = |error: SceneDiagnostic| {
        let (line, _) = error.line_column();
        let text = error.source_text.lines().nth(line.saturating_sub(1));
        let key = text
            .and_then(|line| line.split_once(" = "))
            .map_or("system", |(key, _)| key);
        let help = error
            .help
            .map_or_else(String::new, |help| format!("; {help}"));
        (key.to_owned(), format!("{}{help}", error.message))
    };
    let parse = |initial: usize| {
        let initial = vec!["1"; initial].join(", ");
        let text = format!(
            "{fragment}[method]\ntime-step = 0.1\n[run]\ninitial = [{initial}]\nsteps = 1\n"
        );
        SceneDocument::parse(id, &text, &Registry::empty())
    };
    // The dimension is known once the table has been read.
    let document = parse(1).or_else(|errors| match dimension(fragment) {
        Some(dimension) => parse(dimension),
        None => Err(errors),
    });
    let document = document.map_err(|errors| {
        let first = errors.diagnostics().into_iter().next();
        first.map_or_else(|| ("system".to_owned(), errors.to_string()), of_scene)
    })?;
    let mut instantiated =
        instantiate(&document, &geometry(&document)).map_err(|refusal| of_scene(*refusal))?;
    let forms = std::mem::take(&mut instantiated.forms);
    let system = instantiated.system(&document);
    let system = system.map_err(|error| ("bracket".to_owned(), error.to_string()))?;
    forms
        .apply(&document, system)
        .map_err(|refusal| of_scene(*refusal))
}

/// The number of coordinates that a fragment declares.
fn dimension(fragment: &str) -> Option<usize> {
    let table: toml::Table = toml::from_str(fragment).ok()?;
    let system = table.get("system")?;
    let variables = system.get("variables").and_then(toml::Value::as_array);
    let families = system.get("families").and_then(toml::Value::as_table);
    let sites: i64 = families
        .into_iter()
        .flat_map(toml::Table::values)
        .filter_map(toml::Value::as_integer)
        .sum();
    Some(variables.map_or(0, Vec::len) + usize::try_from(sites).ok()?)
}
