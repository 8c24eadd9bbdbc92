//! `leafwise schema`: the keys of scenes as a JSON Schema.

use leafwise::scene::document::json_schema;

use crate::arguments::PluginArguments;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;

/// Prints the schema; returns the exit code.
///
/// # Errors
/// [`Failure`] where a plugin that is asked for is refused.
pub fn execute(plugins: &PluginArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    console.json(&json_schema(&Parts::new(plugins)?.registry));
    Ok(exit::DONE)
}
