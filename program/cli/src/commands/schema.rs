//! `leafwise schema`: the keys of scenes as a JSON Schema, or as tables.

use leafwise::scene::document::{json_schema, key_tables};

use crate::arguments::{PluginArguments, SchemaArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;

/// Prints the schema, or the tables of the guide; returns the exit code.
///
/// # Errors
/// [`Failure`] where a plugin that is asked for is refused.
pub fn execute(
    arguments: &SchemaArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let registry = Parts::new(plugins)?.registry;
    match arguments.markdown {
        true => console.result(key_tables().trim_end()),
        false => console.json(&json_schema(&registry)),
    }
    Ok(exit::DONE)
}
