//! One trajectory, step by step.

use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

use leafwise::scene::ComposedRun;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::error::IntegrationError;
use crate::functions::Functions;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Steps between two looks at the clock.
const STRIDE: u64 = 256;

/// One trajectory: the method's steps from a scene's initial state.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Integrator {
    own: Mutex<leafwise::core::Walk>,
    /// How many of the coordinates that are stepped are the scene's own.
    coordinates: usize,
    /// Which of them is the time, where steps are of another.
    clock: Option<usize>,
    /// The system, where it is functions of Python.
    functions: Option<Functions>,
}

impl Integrator {
    pub fn new(run: &ComposedRun, functions: Option<Functions>) -> Self {
        Self {
            own: Mutex::new(run.walk()),
            coordinates: run.plan.layout.coordinates(),
            clock: run.time_place(),
            functions,
        }
    }

    /// Nothing waits for it: the thread that has it may wait for the interpreter's lock.
    fn get(&self) -> PyResult<MutexGuard<'_, leafwise::core::Walk>> {
        match self.own.try_lock() {
            Ok(integrator) => Ok(integrator),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "the integrator is stepping, in another thread or in a function of its own system",
            )),
        }
    }

    #[cold]
    fn failure(&self, error: &leafwise::core::StepError) -> PyErr {
        let raised = self.functions.as_ref().and_then(Functions::raised);
        raised.unwrap_or_else(|| IntegrationError::new_err(error.to_string()))
    }
}

#[pymethods]
impl Integrator {
    /// One step.
    fn step(&self) -> PyResult<()> {
        let stepped = self.get()?.step();
        stepped.map_err(|error| self.failure(&error))
    }

    /// So many steps. Ctrl-C ends them between two, with KeyboardInterrupt.
    fn advance(&self, py: Python<'_>, steps: &Bound<'_, PyAny>) -> PyResult<()> {
        let arrays = py.import("leafwise._arrays")?;
        let steps: u64 = arrays
            .call_method1("count", ("steps", steps, 0))?
            .extract()?;
        py.detach(|| {
            let mut integrator = self.get()?;
            let (mut left, mut looked) = (steps, Instant::now());
            while left > 0 {
                let some = left.min(STRIDE);
                let advanced = integrator.advance(some);
                advanced.map_err(|error| self.failure(&error))?;
                left -= some;
                if looked.elapsed() >= LOOK_EVERY {
                    Python::attach(|py| py.check_signals())?;
                    looked = Instant::now();
                }
            }
            Ok(())
        })
    }

    /// The present state: shape (d,), a copy.
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let integrator = self.get()?;
        Ok(PyArray1::from_slice(
            py,
            &integrator.state()[..self.coordinates],
        ))
    }

    /// The present time, also where a pace makes it advance otherwise than the steps.
    #[getter]
    fn t(&self) -> PyResult<f64> {
        let integrator = self.get()?;
        Ok(match self.clock {
            Some(at) => integrator.state()[at],
            None => integrator.time(),
        })
    }

    /// Steps made.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.get()?.steps())
    }

    /// Writes the present state into an array of shape (d,).
    fn copy_to(&self, target: &Bound<'_, PyArray1<f64>>) -> PyResult<()> {
        let mut target = target.try_readwrite()?;
        let integrator = self.get()?;
        let state = &integrator.state()[..self.coordinates];
        let place = target.as_slice_mut()?;
        if place.len() != state.len() {
            return Err(PyValueError::new_err(format!(
                "the array has {} numbers, a state {}",
                place.len(),
                state.len()
            )));
        }
        place.copy_from_slice(state);
        Ok(())
    }
}
