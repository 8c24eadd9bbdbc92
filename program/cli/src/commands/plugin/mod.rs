//! `leafwise plugin`: plugins found, and plugins tried.

mod check;
mod list;
mod measure;

use std::ffi::OsString;
use std::path::Path;

use leafwise::plugins::{Refusal, run_probe};

use crate::arguments::{PluginArguments, PluginCommand};
use crate::console::Console;
use crate::failure::Failure;
use crate::plugins::are_forbidden;
pub use check::completed;

/// Lists, checks or probes; `given` is the whole command line. Returns the exit code.
///
/// # Errors
/// [`Failure::Plugin`] for a plugin that is refused.
pub fn execute(
    command: &PluginCommand,
    plugins: &PluginArguments,
    given: &[OsString],
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    match command {
        PluginCommand::Check(arguments) if plugins.measures_here => {
            measure::execute(arguments, plugins, console)
        }
        PluginCommand::Check(arguments) => check::execute(arguments, given, console),
        PluginCommand::List(arguments) => list::execute(arguments, plugins, console),
        PluginCommand::Probe { path } if are_forbidden(plugins) => {
            Err(Failure::plugin(Refusal::SwitchedOff.of(path), None))
        }
        PluginCommand::Probe { path } => Ok(probe(path, console)),
    }
}

/// The child's side of the probe.
fn probe(path: &Path, console: &mut Console<'_>) -> u8 {
    let mut report = Vec::new();
    let code = run_probe(path, &mut report);
    console.result(&String::from_utf8_lossy(&report));
    code
}
