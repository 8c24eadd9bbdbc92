//! One trajectory, step by step.

use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use crate::error::IntegrationError;

/// One trajectory: the method's steps from a scene's initial state.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Integrator(Mutex<leafwise::core::Integrator>);

impl Integrator {
    pub fn new(integrator: leafwise::core::Integrator) -> Self {
        Self(Mutex::new(integrator))
    }

    fn get(&self) -> MutexGuard<'_, leafwise::core::Integrator> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Integrator {
    /// One step.
    fn step(&self) -> PyResult<()> {
        let mut integrator = self.get();
        integrator.step().map_err(|error| failure(&error))
    }

    /// So many steps.
    fn advance(&self, py: Python<'_>, steps: u64) -> PyResult<()> {
        py.detach(|| self.get().advance(steps))
            .map_err(|error| failure(&error))
    }

    /// The present state: shape (d,), a copy.
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.get().state())
    }

    /// The present time.
    #[getter]
    fn t(&self) -> f64 {
        self.get().time()
    }

    /// Steps made.
    #[getter]
    fn steps(&self) -> u64 {
        self.get().steps()
    }

    /// Writes the present state into an array of shape (d,).
    fn copy_to(&self, target: &Bound<'_, PyArray1<f64>>) -> PyResult<()> {
        let mut target = target.try_readwrite()?;
        let integrator = self.get();
        let state = integrator.state();
        let place = target.as_slice_mut()?;
        if place.len() != state.len() {
            return Err(pyo3::exceptions::PyValueError::new_err(format!(
                "the array has {} numbers, a state {}",
                place.len(),
                state.len()
            )));
        }
        place.copy_from_slice(state);
        Ok(())
    }
}

fn failure(error: &leafwise::core::StepError) -> PyErr {
    IntegrationError::new_err(error.to_string())
}
