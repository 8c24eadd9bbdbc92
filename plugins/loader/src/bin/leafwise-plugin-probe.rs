//! Tries a plugin on behalf of a program that cannot start itself again, such as an interpreter that
//! embeds Leafwise: `leafwise-plugin-probe PATH`.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return ExitCode::from(2);
    };
    ExitCode::from(leafwise_plugin_loader::run_probe(
        &path,
        &mut std::io::stdout(),
    ))
}
