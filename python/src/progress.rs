//! Progress of a run as a function of Python sees it, and its interruption by signals and exceptions.

use std::time::{Duration, Instant};

use leafwise::run::{Progress, Status};
use pyo3::prelude::*;

use crate::error::is_interruption;
use crate::functions::Functions;

/// How often signals are looked for and progress is reported.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Looks for Ctrl-C and exceptions of a system's functions, and tells a function of Python where the run stands.
pub(crate) struct PythonProgress<'a> {
    function: Option<Py<PyAny>>,
    functions: Option<&'a Functions>,
    looked: Instant,
    is_interrupted: bool,
    /// The exception that the function raised.
    raised: Option<PyErr>,
}

impl<'a> PythonProgress<'a> {
    pub(crate) fn new(function: Option<Py<PyAny>>, functions: Option<&'a Functions>) -> Self {
        Self {
            function,
            functions,
            looked: Instant::now(),
            is_interrupted: false,
            raised: None,
        }
    }

    /// Raises what the function, or one of the system's, has raised.
    pub(crate) fn check(&mut self) -> PyResult<()> {
        let of_system = self.functions.and_then(Functions::raised);
        self.raised.take().or(of_system).map_or(Ok(()), Err)
    }

    /// The exception that the function, or one of the system's, raised.
    pub(crate) fn into_raised(self) -> Option<PyErr> {
        let of_system = self.functions.and_then(Functions::raised);
        self.raised.or(of_system)
    }
}

impl Progress for PythonProgress<'_> {
    fn show(&mut self, status: &Status) {
        if self.looked.elapsed() < LOOK_EVERY || self.is_interrupted {
            return;
        }
        Python::attach(|py| {
            self.is_interrupted = py.check_signals().is_err();
            if let Some(function) = &self.function
                && let Err(error) = function.call1(py, (status.steps, status.total))
            {
                self.is_interrupted = true;
                // Ctrl-C while the function runs.
                self.raised = (!is_interruption(&error)).then_some(error);
            }
        });
        self.looked = Instant::now();
    }

    fn is_interrupted(&self) -> bool {
        self.is_interrupted || self.functions.is_some_and(Functions::has_raised)
    }
}
