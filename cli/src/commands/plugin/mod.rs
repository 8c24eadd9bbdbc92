//! `leafwise plugin`: plugins found, and plugins tried.

mod check;
mod list;

use std::path::Path;

use leafwise::plugins::run_probe;

use crate::arguments::{PluginArguments, PluginCommand};
use crate::console::Console;
use crate::failure::Failure;

/// Lists, checks or probes; returns the exit code.
///
/// # Errors
/// [`Failure::Plugin`] for a plugin that is refused.
pub fn execute(
    command: &PluginCommand,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    match command {
        PluginCommand::Check(arguments) => check::execute(arguments, plugins, console),
        PluginCommand::List(arguments) => list::execute(arguments, plugins, console),
        PluginCommand::Probe { path } => Ok(probe(path)),
    }
}

/// The child's side of the probe: its report goes to the standard output itself.
fn probe(path: &Path) -> u8 {
    run_probe(path, &mut std::io::stdout())
}
