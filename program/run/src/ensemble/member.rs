//! One member as a scene of its own.

use thiserror::Error;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Value};

use super::plan::ComposedEnsemble;
use super::population::NoMember;
use leafwise_scene::document::{CHOSEN_AT, SceneDocument};

/// Why a member has no scene.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MemberError {
    /// A number beyond the last.
    #[error("there is no member {member}: they are 0 to {}", members - 1)]
    Absent {
        /// The number asked for.
        member: u64,
        /// How many there are.
        members: u64,
    },
    /// A member without an initial state.
    #[error("member {member} has no initial state: {reason}")]
    NoState {
        /// The number asked for.
        member: u64,
        /// Why.
        reason: NoMember,
    },
    /// A scene whose text cannot be rewritten.
    #[error("the scene cannot be written for one member: {reason}")]
    Rewrite {
        /// Why.
        reason: String,
    },
}

/// The scene's text with one member's initial state and parameters, and without `[ensemble]`: an
/// ordinary run of it is the member's trajectory, to the bit. All members step by one method, whose parts
/// chose what they are made of at the scene's own parameters: `[method] chosen-at` keeps their values.
///
/// # Errors
/// [`MemberError`].
pub fn member_scene(
    document: &SceneDocument,
    ensemble: &ComposedEnsemble,
    member: u64,
) -> Result<String, MemberError> {
    let members = ensemble.population.members();
    if member >= members {
        return Err(MemberError::Absent { member, members });
    }
    let drawn = ensemble.population.draw(member);
    let (state, parameters) = drawn.map_err(|reason| MemberError::NoState { member, reason })?;
    let rewrite = |reason: String| MemberError::Rewrite { reason };
    let mut scene: DocumentMut = document
        .text
        .parse()
        .map_err(|error: toml_edit::TomlError| rewrite(error.message().to_owned()))?;
    scene.remove("ensemble");
    let missing = |table: &str| rewrite(format!("it has no [{table}]"));
    let run = scene.get_mut("run").and_then(Item::as_table_like_mut);
    let initial: Array = ensemble.run.own(&state).iter().copied().collect();
    let run = run.ok_or_else(|| missing("run"))?;
    run.insert("initial", Item::Value(Value::Array(initial)));
    if let (Some(_), Some(section)) = (ensemble.run.method.noise(), &document.ensemble) {
        for (key, value) in [("seed", section.seed), ("member", member)] {
            let value = i64::try_from(value).map_err(|_| {
                rewrite(format!(
                    "{value} is not a whole number of TOML: take a smaller seed"
                ))
            })?;
            run.insert(key, Item::Value(Value::from(value)));
        }
    }
    let declared = ensemble.run.system.parameters();
    let varied = ensemble.population.varied();
    if !varied.is_empty() && ensemble.run.system.expressions().is_some() {
        let method = scene.get_mut("method").and_then(Item::as_table_like_mut);
        let method = method.ok_or_else(|| missing("method"))?;
        let table = method
            .entry(CHOSEN_AT)
            .or_insert(Item::Value(Value::InlineTable(InlineTable::new())));
        let chosen = table.as_table_like_mut();
        let chosen = chosen.ok_or_else(|| rewrite(format!("`{CHOSEN_AT}` is not a table")))?;
        for parameter in varied.iter().map(|at| &declared[*at]) {
            if !chosen.contains_key(&parameter.name) {
                chosen.insert(&parameter.name, Item::Value(Value::from(parameter.value)));
            }
        }
    }
    let system = scene.get_mut("system").and_then(Item::as_table_like_mut);
    let system = system.ok_or_else(|| missing("system"))?;
    for at in ensemble.population.varied() {
        let table = system
            .entry("parameters")
            .or_insert(Item::Value(Value::InlineTable(InlineTable::new())));
        let table = table
            .as_table_like_mut()
            .ok_or_else(|| rewrite("its `parameters` are not a table".to_owned()))?;
        table.insert(&declared[at].name, Item::Value(Value::from(parameters[at])));
    }
    Ok(scene.to_string())
}
