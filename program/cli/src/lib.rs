//! The `leafwise` program as a library: arguments in, text and an exit code out.
//!
//! - [`arguments`]: the command line.
//! - [`console`]: where text goes.
//! - [`failure`]: errors and their exit codes.
//! - [`interrupt`]: the flag that Ctrl-C raises.
//! - [`scene`]: reading a scene with its overrides.
//! - [`commands`]: one module for each command.
//! - [`plugins`]: the plugins that a command line and a scene ask for.
//! - [`bar`]: the progress bar; [`pulse`]: lines in its place.
//! - [`files`]: files that a command writes.
//! - [`fmu`]: functional mock-up units of scenes.
//! - [`table`]: aligned columns.

pub mod arguments;
pub mod bar;
pub mod commands;
pub mod console;
pub mod failure;
pub mod files;
pub mod fmu;
pub mod guide;
pub mod interrupt;
pub mod plugins;
pub mod pulse;
pub mod scene;
mod synonyms;
pub mod table;

use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use leafwise::expression::Execution;
use leafwise::plugins::change_of_arithmetic;

use arguments::{Arguments, Command};
use console::Console;
use failure::{Failure, exit};

/// Runs the program on its arguments, the program's own name first; returns the exit code.
///
/// `interrupt` asks a run to write a checkpoint and stop.
pub fn run(
    arguments: impl IntoIterator<Item = OsString>,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> u8 {
    let given: Vec<OsString> = arguments.into_iter().collect();
    let asks_for_json = given.iter().any(|argument| argument == "--json");
    let code = match Arguments::try_parse_from(&given) {
        Ok(arguments) => execute(arguments, &given, console, interrupt),
        Err(error) => tell(&error, console, asks_for_json),
    };
    match console.lost.take() {
        Some(error) if code == exit::DONE => {
            let word = console.error_word();
            console.prose(&format!(
                "{word} cannot write the result to standard output: {error}"
            ));
            exit::RUN_FAILED
        }
        _ => code,
    }
}

/// Prints what the arguments are wrong with, or the help or version that they ask for.
fn tell(error: &clap::Error, console: &mut Console<'_>, asks_for_json: bool) -> u8 {
    let text = error.render();
    let shown = if console.color {
        text.ansi().to_string()
    } else {
        text.to_string()
    };
    if !error.use_stderr() {
        console.result(shown.trim_end());
        return exit::DONE;
    }
    console.prose(shown.trim_end());
    if asks_for_json {
        let plain = text.to_string();
        let first = plain.split("\n\n").next().unwrap_or_default();
        let message = first.trim_start_matches("error: ").to_owned();
        console.json(
            &Failure::Usage {
                message,
                help: None,
            }
            .json(),
        );
    }
    exit::USAGE
}

/// Executes a command; `given` is the whole command line.
fn execute(
    arguments: Arguments,
    given: &[OsString],
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> u8 {
    Execution::from(arguments.kernels).set_default_of_process();
    let json = arguments.command.wants_json();
    let plugins = &arguments.plugins;
    let outcome = match arguments.command {
        Command::New(_) | Command::Stress(_) | Command::Reproduce(_)
            if !plugins.plugins.is_empty() =>
        {
            Err(Failure::usage(
                "`--plugin` has no meaning here: this command works with built-in parts",
                "leave it out; a scene names its libraries itself, plugins = [\"./libacme.so\"]",
            ))
        }
        Command::Run(arguments) => commands::run::execute(&arguments, plugins, console, interrupt),
        Command::Ensemble(arguments) => {
            commands::ensemble::execute(&arguments, plugins, console, interrupt)
        }
        Command::Sweep(arguments) => {
            commands::sweep::execute(&arguments, plugins, console, interrupt)
        }
        Command::Merge(arguments) => commands::merge::execute(&arguments, plugins, console),
        Command::Check(arguments) => commands::check::execute(&arguments, plugins, console),
        Command::Compare(arguments) => {
            commands::compare::execute(&arguments, plugins, console, interrupt)
        }
        Command::Verify(arguments) => commands::verify::execute(&arguments, plugins, console),
        Command::List(arguments) => commands::list::execute(&arguments, plugins, console),
        Command::Describe(arguments) => commands::describe::execute(&arguments, plugins, console),
        Command::Evaluate(arguments) => commands::evaluate::execute(&arguments, plugins, console),
        Command::Find(arguments) => commands::find::execute(&arguments, plugins, console),
        Command::Import(arguments) => commands::import::execute(&arguments, console),
        Command::Plot(arguments) => commands::plot::execute(&arguments, console),
        Command::Learn(arguments) => commands::learn::execute(&arguments, plugins, console),
        Command::Tabulate(arguments) => commands::tabulate::execute(&arguments, plugins, console),
        Command::Shadow(arguments) => commands::shadow::execute(&arguments, plugins, console),
        Command::Orbit(arguments) => commands::orbit::execute(&arguments, plugins, console),
        Command::Fmu(arguments) => commands::fmu::execute(&arguments, plugins, console),
        Command::Tune(arguments) => commands::tune::execute(&arguments, plugins, console),
        Command::Reproduce(arguments) => {
            commands::reproduce::execute(&arguments, console, interrupt)
        }
        Command::Stress(arguments) => commands::stress::execute(&arguments, console, interrupt),
        Command::New(arguments) => commands::new::execute(&arguments, console),
        Command::Explain(arguments) => commands::explain_word::execute(&arguments, console),
        Command::Schema(arguments) => commands::schema::execute(&arguments, plugins, console),
        Command::Plugin(command) => commands::plugin::execute(&command, plugins, given, console),
    };
    let mut code = outcome.unwrap_or_else(|failure: Failure| failure.print(console, json));
    if let Some(change) = change_of_arithmetic() {
        let word = console.error_word();
        console.prose(&format!(
            "{word} {change}; numbers computed since then are not reliable"
        ));
        if code == exit::DONE {
            code = exit::RUN_FAILED;
        }
    }
    if plugins.measures_here {
        console.verbatim(&commands::plugin::completed(code));
    }
    code
}
