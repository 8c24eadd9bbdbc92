//! The samples of a scene as a function of the initial state and the parameters, with its derivatives.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use leafwise::core::gradient::times;
use leafwise::core::gradient::{self, GradientError, Plan, Pushed, Reached, Way};
use leafwise::run::with_room;
use leafwise::scene::ComposedRun;
use numpy::{
    PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3,
};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::error::{IntegrationError, LeafwiseError, no_memory};
use crate::functions::Functions;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Samples (n, d), and the states kept for the way back, each with what it holds beyond a double: (pieces, 2, stepped
/// coordinates).
type Run<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

/// Samples (n, d), their tangents (n, k, d), and how these grew.
type Tangents<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>, Growth);

/// The gradient by the initial state (d,) and by the parameters, how it grew, and whether checkpoints were taken.
type Gradient<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Growth,
    bool,
);

/// States (n, d) and their tangents (n, k, d).
type Moved<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

/// How fast derivatives grew, and how many of their digits that leaves.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Growth(gradient::Growth);

#[pymethods]
impl Growth {
    /// ln of the factor by which they grew.
    #[getter]
    fn logarithm(&self) -> f64 {
        self.0.logarithm
    }

    /// The factor's logarithm over time: along chaotic motion the largest Lyapunov exponent.
    #[getter]
    fn rate(&self) -> f64 {
        self.0.rate()
    }

    /// Decimal digits left: 16 at most, negative where none is.
    #[getter]
    fn digits(&self) -> f64 {
        self.0.digits()
    }

    /// Whether fewer than six are left.
    #[getter]
    fn is_large(&self) -> bool {
        self.0.is_large()
    }

    #[new]
    fn new(logarithm: f64, time: f64) -> Self {
        Self(gradient::Growth { logarithm, time })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, (f64, f64)) {
        let own = slf.get().0;
        (slf.get_type(), (own.logarithm, own.time))
    }

    fn __repr__(&self) -> String {
        format!("<leafwise.Growth {}>", self.0)
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }
}

/// Steps, and every how many of them there is a sample.
fn as_plan((steps, every): (u64, u64)) -> Plan {
    Plan { steps, every }
}

/// A scene's method, ready to be stepped from any state with any parameters.
#[pyclass(frozen, module = "leafwise")]
pub(crate) struct Map {
    run: ComposedRun,
    /// Those of a system of Python's.
    functions: Option<Functions>,
}

impl Map {
    /// The map of a scene.
    ///
    /// # Errors
    /// [`LeafwiseError`] for a scene whose samples are not those after so many equal steps.
    pub fn new(run: ComposedRun, functions: Option<Functions>) -> PyResult<Self> {
        let uneven = run.has_equal_steps();
        uneven.map_err(|uneven| LeafwiseError::new_err(uneven.to_string()))?;
        Ok(Self { run, functions })
    }

    /// Calls with the trajectories at these parameters; Ctrl-C ends them, and what a function of the system raises.
    fn at<T: Send>(
        &self,
        py: Python<'_>,
        parameters: &[f64],
        call: impl FnOnce(gradient::Trajectory<'_>) -> Result<T, GradientError> + Send,
    ) -> PyResult<T> {
        let looked = Mutex::new(Instant::now());
        let raised = Mutex::new(None);
        let functions = self.functions.as_ref();
        let goes_on = || {
            let mut looked = looked.lock().unwrap_or_else(PoisonError::into_inner);
            if looked.elapsed() < LOOK_EVERY {
                return true;
            }
            *looked = Instant::now();
            let signalled = Python::attach(|py| py.check_signals());
            let is_quiet = signalled.is_ok();
            *raised.lock().unwrap_or_else(PoisonError::into_inner) = signalled.err();
            is_quiet
        };
        let plan = &self.run.plan;
        let found = py.detach(|| {
            call(gradient::Trajectory {
                map: self.run.method.map(),
                parameters,
                epsilon: plan.epsilon,
                h: plan.h,
                goes_on: &goes_on,
            })
        });
        if let Some(error) = functions.and_then(Functions::raised) {
            return Err(error);
        }
        found.map_err(|error| match error {
            GradientError::Interrupted => (raised.into_inner())
                .unwrap_or_else(PoisonError::into_inner)
                .unwrap_or_else(|| PyKeyboardInterrupt::new_err(())),
            GradientError::Step { .. } => IntegrationError::new_err(error.to_string()),
            other => LeafwiseError::new_err(other.to_string()),
        })
    }

    /// Refuses a plan whose samples, with k tangents each, find no memory.
    fn has_room(&self, plan: Plan, tangents: usize) -> PyResult<()> {
        let rows = (plan.steps / plan.every).saturating_add(1);
        // The states that are stepped, and beside them the scene's own coordinates that are handed out.
        let width = 2 * self.run.plan.layout.dimension() * (1 + tangents);
        let room = with_room(rows, width).map(drop);
        room.map_err(|no_room| no_memory(&no_room))
    }

    fn dimension(&self) -> usize {
        self.run.plan.layout.coordinates()
    }
}

#[pymethods]
impl Map {
    /// The scene's initial state, shape (d,).
    #[getter]
    fn initial<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.run.own(&self.run.plan.initial))
    }

    /// How many coordinates are stepped: two more than d where the system names the time.
    #[getter]
    fn width(&self) -> usize {
        self.run.plan.layout.dimension()
    }

    /// The time of a step.
    #[getter]
    fn time_step(&self) -> f64 {
        self.run.plan.epsilon * self.run.plan.h
    }

    /// The scene's number of steps, and every how many of them it keeps a sample.
    #[getter]
    fn plan(&self) -> (u64, u64) {
        let every = match self.run.plan.samples {
            leafwise::walk::SampleTimes::Every(every) => every,
            _ => 1,
        };
        (self.run.plan.steps, every)
    }

    /// How many states a run keeps for the way back.
    #[staticmethod]
    fn pieces(plan: (u64, u64)) -> usize {
        as_plan(plan).pieces()
    }

    /// The run from `initial`.
    fn run<'py>(
        &self,
        py: Python<'py>,
        initial: PyReadonlyArray1<'py, f64>,
        parameters: PyReadonlyArray1<'py, f64>,
        plan: (u64, u64),
    ) -> PyResult<Run<'py>> {
        let initial = self.run.whole(initial.as_slice()?);
        let plan = as_plan(plan);
        self.has_room(plan, 0)?;
        let run = self.at(py, parameters.as_slice()?, |at| at.run(&initial, plan))?;
        let samples = PyArray1::from_vec(py, self.run.own_rows(&run.samples));
        let kept = PyArray1::from_vec(py, run.kept);
        Ok((
            samples.reshape([plan.samples(), self.dimension()])?,
            kept.reshape([plan.pieces(), 2, initial.len()])?,
        ))
    }

    /// How many of a plan's steps can be taken.
    fn reach<'py>(
        &self,
        py: Python<'py>,
        initial: PyReadonlyArray1<'py, f64>,
        parameters: PyReadonlyArray1<'py, f64>,
        steps: u64,
    ) -> PyResult<u64> {
        let initial = self.run.whole(initial.as_slice()?);
        let plan = Plan {
            steps,
            every: steps.max(1),
        };
        self.at(py, parameters.as_slice()?, |at| {
            match at.run(&initial, plan) {
                Ok(_) => Ok(steps),
                Err(GradientError::Step { step, .. }) => Ok(step),
                Err(other) => Err(other),
            }
        })
    }

    /// States at times on the way of the run, ends of shorter steps, and their tangents in k directions, which may be none.
    fn push_to<'py>(
        &self,
        py: Python<'py>,
        initial: PyReadonlyArray1<'py, f64>,
        parameters: PyReadonlyArray1<'py, f64>,
        tangents: PyReadonlyArray2<'py, f64>,
        by_parameters: PyReadonlyArray2<'py, f64>,
        times: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Moved<'py>> {
        let initial = self.run.whole(initial.as_slice()?);
        let tangents = self.run.whole_rows(tangents.as_slice()?);
        let (by_parameters, times) = (by_parameters.as_slice()?, times.as_slice()?);
        let (n, k) = (times.len(), tangents.len() / initial.len());
        let (states, moved) = self.at(py, parameters.as_slice()?, |at| {
            times::push(&at, (initial, tangents), by_parameters, times)
        })?;
        let d = self.dimension();
        Ok((
            PyArray1::from_vec(py, self.run.own_rows(&states)).reshape([n, d])?,
            PyArray1::from_vec(py, self.run.own_rows(&moved)).reshape([n, k, d])?,
        ))
    }

    /// Tangents of every sample in k directions: of the initial state (k, d), of the parameters (k, p) with p = 0 for none.
    fn push<'py>(
        &self,
        py: Python<'py>,
        initial: PyReadonlyArray1<'py, f64>,
        parameters: PyReadonlyArray1<'py, f64>,
        tangents: PyReadonlyArray2<'py, f64>,
        by_parameters: PyReadonlyArray2<'py, f64>,
        plan: (u64, u64),
    ) -> PyResult<Tangents<'py>> {
        let initial = self.run.whole(initial.as_slice()?);
        let tangents = self.run.whole_rows(tangents.as_slice()?);
        let directions = (&tangents[..], by_parameters.as_slice()?);
        let plan = as_plan(plan);
        self.has_room(plan, tangents.len() / initial.len())?;
        let pushed = self.at(py, parameters.as_slice()?, |at| {
            at.push(&initial, directions, plan)
        })?;
        let Pushed {
            samples,
            tangents: moved,
            growth,
        } = pushed;
        let (n, d) = (plan.samples(), self.dimension());
        let k = tangents.len() / initial.len();
        Ok((
            PyArray1::from_vec(py, self.run.own_rows(&samples)).reshape([n, d])?,
            PyArray1::from_vec(py, self.run.own_rows(&moved)).reshape([n, k, d])?,
            Growth(growth),
        ))
    }

    /// The gradient of a function of the samples by the initial state, and where asked by the parameters. The function
    /// has the derivatives `cotangents` (n, d). The states `kept` are those that the run kept.
    #[allow(clippy::too_many_arguments)]
    fn pull<'py>(
        &self,
        py: Python<'py>,
        initial: PyReadonlyArray1<'py, f64>,
        parameters: PyReadonlyArray1<'py, f64>,
        kept: PyReadonlyArray3<'py, f64>,
        cotangents: PyReadonlyArray2<'py, f64>,
        by_parameters: bool,
        plan: (u64, u64),
    ) -> PyResult<Gradient<'py>> {
        let initial = self.run.whole(initial.as_slice()?);
        let reached = Reached {
            samples: Vec::new(),
            kept: kept.as_slice()?.to_vec(),
        };
        let cotangents = self.run.whole_rows(cotangents.as_slice()?);
        let plan = as_plan(plan);
        let found = self.at(py, parameters.as_slice()?, |at| {
            at.pull(&initial, &reached, &cotangents, plan, (by_parameters, None))
        })?;
        Ok((
            PyArray1::from_slice(py, self.run.own(&found.initial)),
            PyArray1::from_vec(py, found.parameters),
            Growth(found.growth),
            found.way == Way::Checkpoints,
        ))
    }
}
