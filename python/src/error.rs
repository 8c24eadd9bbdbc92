//! The program's failures as exceptions, in its words and with its places.

use leafwise::run::{NoRoom, RunError};
use leafwise::scene::{SceneDiagnostic, SceneErrors};
use leafwise_cli::console::Console;
use leafwise_cli::failure::{Failure, exit};
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyMemoryError};
use pyo3::{PyErr, Python};

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
    if let Failure::Run(RunError::NoRoom(no_room)) = failure {
        return no_memory(no_room);
    }
    let in_words_of_python = match failure {
        Failure::Scene(problems) => Some(Failure::Scene(problems.iter().map(of_python).collect())),
        _ => None,
    };
    let failure = in_words_of_python.as_ref().unwrap_or(failure);
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = failure.print(&mut Console::new(&mut out, &mut err, false, false), false);
    of_code(code, &String::from_utf8_lossy(&err))
}

/// Python's exception for the want of memory.
pub(crate) fn no_memory(no_room: &NoRoom) -> PyErr {
    PyMemoryError::new_err(no_room.to_string())
}

/// Names of flags in the program's messages, with the words that a caller from Python uses for them and for the values
/// that they set.
const WORDS: [(&str, &str); 3] = [
    (" with --set", " with the values set"),
    ("--set", "values set"),
    ("pass --allow-non-poisson", "pass allow_non_poisson=True"),
];

/// A problem in words of Python.
fn of_python(problem: &SceneDiagnostic) -> SceneDiagnostic {
    let in_words = |text: &str| {
        let words = WORDS.iter();
        words.fold(text.to_owned(), |text, (flag, word)| {
            text.replace(flag, word)
        })
    };
    SceneDiagnostic {
        message: in_words(&problem.message),
        source_name: in_words(&problem.source_name),
        help: problem.help.as_deref().map(in_words),
        ..problem.clone()
    }
}

/// Problems of a scene.
pub(crate) fn of_scene(errors: &SceneErrors) -> PyErr {
    exception(&Failure::Scene(errors.diagnostics()))
}

/// The exception for a command that printed `text` and ended with this exit code.
pub(crate) fn of_code(code: u8, text: &str) -> PyErr {
    let text = text.trim();
    let text = text.strip_prefix("error: ").unwrap_or(text).to_owned();
    match code {
        exit::INVALID_SCENE => SceneError::new_err(text),
        _ => LeafwiseError::new_err(text),
    }
}

/// Whether it is Ctrl-C.
pub(crate) fn is_interruption(error: &PyErr) -> bool {
    Python::attach(|py| error.is_instance_of::<PyKeyboardInterrupt>(py))
}
