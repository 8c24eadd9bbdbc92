//! The program's failures as exceptions, in its words and with its places.

use leafwise::scene::SceneErrors;
use leafwise_cli::console::Console;
use leafwise_cli::failure::{Failure, exit};
use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyException;

create_exception!(
    leafwise,
    LeafwiseError,
    PyException,
    "What a command or a run cannot do, and what to try."
);
create_exception!(
    leafwise,
    SceneError,
    LeafwiseError,
    "A scene that is not valid: each problem where it stands."
);
create_exception!(
    leafwise,
    IntegrationError,
    LeafwiseError,
    "A step that could not be taken; `run` holds everything recorded before it."
);

/// A failure with everything that the program would print of it.
pub(crate) fn exception(failure: &Failure) -> PyErr {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = failure.print(&mut Console::new(&mut out, &mut err, false, false), false);
    of_code(code, &String::from_utf8_lossy(&err))
}

/// Problems of a scene.
pub(crate) fn of_scene(errors: &SceneErrors) -> PyErr {
    exception(&Failure::Scene(errors.diagnostics()))
}

/// What a command printed before it ended with this code.
pub(crate) fn of_code(code: u8, text: &str) -> PyErr {
    let text = text.trim();
    let text = text.strip_prefix("error: ").unwrap_or(text).to_owned();
    match code {
        exit::INVALID_SCENE => SceneError::new_err(text),
        _ => LeafwiseError::new_err(text),
    }
}
