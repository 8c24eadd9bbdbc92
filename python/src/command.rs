//! The program, in this process.

use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use leafwise_cli::console::Console;
use pyo3::prelude::*;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Runs the program on arguments: its exit code, standard output and standard error. Ctrl-C interrupts it as in a terminal.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<(u8, String, String)> {
    let name = OsString::from("leafwise");
    let arguments: Vec<OsString> = std::iter::once(name).chain(arguments).collect();
    let interrupt = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupt);
    let worker = std::thread::spawn(move || {
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let mut console = Console::new(&mut out, &mut err, false, false);
        let code = leafwise_cli::run(arguments, &mut console, &flag);
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        (code, text(out), text(err))
    });
    let mut raised = None;
    while !worker.is_finished() {
        if let Err(error) = py.check_signals() {
            interrupt.store(true, Ordering::Relaxed);
            raised = Some(error);
        }
        py.detach(|| std::thread::sleep(LOOK_EVERY.min(Duration::from_millis(5))));
    }
    let told = worker.join();
    match (raised, told) {
        (Some(error), _) => Err(error),
        (None, Ok(told)) => Ok(told),
        (None, Err(_)) => Err(super::error::LeafwiseError::new_err(
            "the command ended in the middle: this is a mistake of the program",
        )),
    }
}
