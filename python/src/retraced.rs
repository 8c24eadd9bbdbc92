//! The states of a run at any times.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use leafwise::run::{Retrace, Retraced as States};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::error::IntegrationError;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// The states of a run at any times, stepped again from the nearest one that is kept.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Retraced {
    states: Mutex<States>,
    dimension: usize,
}

impl Retraced {
    pub fn new(states: States, dimension: usize) -> Self {
        Self {
            states: Mutex::new(states),
            dimension,
        }
    }
}

#[pymethods]
impl Retraced {
    /// The states at times (k,), shape (k, d).
    fn at<'py>(
        &self,
        py: Python<'py>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let times = times.as_slice()?.to_vec();
        let count = times.len();
        let found = py.detach(|| {
            let mut looked = Instant::now();
            let mut raised = None;
            let mut goes_on = || {
                if looked.elapsed() >= LOOK_EVERY {
                    looked = Instant::now();
                    raised = Python::attach(|py| py.check_signals()).err();
                }
                raised.is_none()
            };
            let mut states = self.states.lock().unwrap_or_else(PoisonError::into_inner);
            let mut found = Vec::with_capacity(count * self.dimension);
            for time in times {
                match states.at(time, &mut goes_on) {
                    Ok(state) => found.extend(state),
                    Err(Retrace::Interrupted) => {
                        let interrupted = || PyKeyboardInterrupt::new_err(());
                        return Err(raised.unwrap_or_else(interrupted));
                    }
                    Err(Retrace::Failed(failure)) => {
                        return Err(IntegrationError::new_err(format!(
                            "step {} failed at t = {}: {}; {}",
                            failure.step, failure.time, failure.message, failure.hint
                        )));
                    }
                }
            }
            Ok(found)
        })?;
        PyArray1::from_vec(py, found).reshape([count, self.dimension])
    }

    /// The steps that were made so far.
    #[getter]
    fn steps(&self) -> u64 {
        let states = self.states.lock().unwrap_or_else(PoisonError::into_inner);
        states.steps()
    }
}
