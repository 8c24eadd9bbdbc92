//! The child's side of the probe.

use std::io::Write;
use std::path::Path;

use super::MARK;
use crate::file;
use crate::opened::open_and_try;
use crate::platform;

/// Opens a library, tries its parts, and writes the report for the process that waits for it: the
/// whole of the child process. The caller ends with the exit code returned, whatever the outcome.
pub fn run_probe(path: &Path, out: &mut dyn Write) -> u8 {
    platform::no_core_dumps();
    let tried = file::check(path, None).and_then(|checked| open_and_try(path, &checked));
    let refusal = tried.err();
    let Ok(json) = serde_json::to_string(&refusal) else {
        return 1;
    };
    // A library may have left its own line unfinished.
    match writeln!(out, "\n{MARK}{json}").and_then(|()| out.flush()) {
        Ok(()) => 0,
        Err(_) => 1,
    }
}
