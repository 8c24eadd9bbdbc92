//! Keys that name variables, `x[i]` or `x[i],x[i+1]`, with the names of the scene's sites.

use leafwise_expression::syntax::VariablePattern;

use super::Refusal;
use super::names::refusal;
use crate::document::{Located, SceneDocument};

/// The variable that a key names.
///
/// # Errors
/// A key that is something else, or names no site, underlined in the scene.
pub(super) fn variable(
    document: &SceneDocument,
    key: &Located<String>,
) -> Result<VariablePattern, Refusal> {
    VariablePattern::parse_one(&key.value)
        .and_then(|pattern| pattern.with_sites(&document.system.site_names))
        .map_err(|error| refusal(document, key, &error))
}

/// The two variables that a key names, with a comma between.
///
/// # Errors
/// A key that is something else, or names no site, underlined in the scene.
pub(super) fn pair(
    document: &SceneDocument,
    key: &Located<String>,
) -> Result<(VariablePattern, VariablePattern), Refusal> {
    let sites = &document.system.site_names;
    VariablePattern::parse_pair(&key.value)
        .and_then(|(first, second)| Ok((first.with_sites(sites)?, second.with_sites(sites)?)))
        .map_err(|error| refusal(document, key, &error))
}
