//! Plugins on the command line and in scenes.

#![cfg(unix)]

#[path = "../../../../../plugins/loader/tests/support/build.rs"]
mod build;
mod checks;
mod numbers;
mod page;
mod refusals;
mod wrong;

use std::path::Path;
use std::process::Command;

use crate::support::{Place, Said};

/// The program with folders of its own for its cache, and no plugins of this machine.
fn command(here: &Place, arguments: &[&str]) -> Command {
    let mut command = here.command(arguments);
    command
        .env("XDG_CACHE_HOME", here.path("cache"))
        .env("XDG_DATA_HOME", here.path("data"))
        .env_remove("LEAFWISE_PLUGIN_PATH")
        .env_remove("LEAFWISE_NO_PLUGINS");
    command
}

fn leafwise(here: &Place, arguments: &[&str]) -> Said {
    let output = command(here, arguments).output();
    Said::from(output.expect("the program starts"))
}

/// A scene with the plugins given, a system, a method and a start.
fn scene(plugins: &[&Path], system: &str, method: &str, initial: &str) -> String {
    let plugins: Vec<String> = plugins
        .iter()
        .map(|path| format!("{:?}", path.display().to_string()))
        .collect();
    format!(
        "plugins = [{}]\n[system]\n{system}\n[method]\n{method}\ntime-step = 0.05\n\
         [run]\ninitial = {initial}\nsteps = 200\n",
        plugins.join(", ")
    )
}
