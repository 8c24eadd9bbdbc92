//! The program, in this process.

use std::ffi::OsString;
use std::io::{self, IsTerminal, LineWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use leafwise::plugins::PluginRequest;
use leafwise_cli::arguments::PluginArguments;
use leafwise_cli::console::Console;
use leafwise_cli::plugins::{self, Parts};
use pyo3::prelude::*;

use crate::error::exception;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Runs the program on arguments: its exit code, standard output and standard error. Ctrl-C interrupts it as in a terminal.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<(u8, String, String)> {
    let plugins = loaded().into_iter();
    let plugins = plugins.flat_map(|path| ["--plugin".into(), path.into_os_string()]);
    let arguments: Vec<OsString> = plugins.chain(arguments).collect();
    beside(py, move |interrupt| {
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let mut console = Console::new(&mut out, &mut err, false, false);
        let code = leafwise_cli::run(named(arguments), &mut console, interrupt);
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        (code, text(out), text(err))
    })
}

/// Runs the program on arguments, on this process's own output: its exit code.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    beside(py, move |interrupt| {
        let (mut out, mut err) = (LineWriter::new(io::stdout()), io::stderr());
        let is_terminal = err.is_terminal();
        let color = is_terminal && std::env::var_os("NO_COLOR").is_none();
        let mut console = Console::new(&mut out, &mut err, color, is_terminal);
        leafwise_cli::run(named(arguments), &mut console, interrupt)
    })
}

/// The arguments behind the program's name.
fn named(arguments: Vec<OsString>) -> impl Iterator<Item = OsString> {
    std::iter::once(OsString::from("leafwise")).chain(arguments)
}

/// Says which file with which arguments starts the program: plugins are tried in a process of its own.
#[pyfunction]
pub(crate) fn start_again_by(program: PathBuf, arguments: Vec<OsString>) {
    plugins::start_again_by(program, arguments);
}

/// The libraries whose parts every scene from now on may name.
static LOADED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Loads the parts of a library, after trying it in a process of its own.
#[pyfunction]
pub(crate) fn load_plugin(py: Python<'_>, path: PathBuf) -> PyResult<()> {
    py.detach(|| {
        let mut known = with_plugins()?;
        let loaded = known.load(&PluginRequest::new(&path), Path::new("."));
        loaded.map_err(|failure| exception(&failure))
    })?;
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    if !loaded.contains(&path) {
        loaded.push(path);
    }
    Ok(())
}

fn loaded() -> Vec<PathBuf> {
    let loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    loaded.clone()
}

/// The built-in parts, and those of the plugins that were loaded.
pub(crate) fn with_plugins() -> PyResult<Parts> {
    let arguments = PluginArguments {
        plugins: loaded(),
        ..PluginArguments::default()
    };
    Parts::new(&arguments).map_err(|failure| exception(&failure))
}

/// Works in a thread of its own, with a flag that Ctrl-C raises.
fn beside<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Arc<AtomicBool>) -> T + Send + 'static,
) -> PyResult<T> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupt);
    let worker = std::thread::spawn(move || work(&flag));
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
            "the command panicked: this is a defect of the program",
        )),
    }
}

/// The version of the package.
#[pyfunction]
pub(crate) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
