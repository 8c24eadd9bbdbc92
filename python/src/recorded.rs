//! Results of a run, as arrays.

use leafwise::report::{ReportData, render_report};
use leafwise::run::{self, NoStateError, RunOutcome, RunReport, StateError};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::error::LeafwiseError;

/// An estimated error of states: the largest, its time, that at the end, and whether it is large.
pub(crate) type ErrorOfStates = (f64, f64, f64, bool);

/// The same as a tuple.
pub(crate) fn as_tuple(error: StateError) -> ErrorOfStates {
    (error.largest, error.time, error.at_end, error.is_large)
}

/// A run in memory.
#[pyclass(frozen, module = "leafwise._leafwise")]
pub(crate) struct Recorded {
    /// The names of `samples`' columns.
    #[pyo3(get)]
    columns: Vec<String>,
    /// How many of them are coordinates, behind the time.
    #[pyo3(get)]
    coordinates: usize,
    /// A row for each sample.
    #[pyo3(get)]
    samples: Py<PyArray2<f64>>,
    /// A row for each crossing of the section, if there is one.
    #[pyo3(get)]
    crossings: Option<Py<PyArray2<f64>>>,
    /// The names of `windows`' columns.
    #[pyo3(get)]
    windows_columns: Vec<String>,
    /// A row for each window of steps.
    #[pyo3(get)]
    windows: Py<PyArray2<f64>>,
    /// The last state.
    #[pyo3(get)]
    final_state: Py<PyArray1<f64>>,
    /// done, stopped, interrupted or failed.
    #[pyo3(get)]
    outcome: &'static str,
    /// Whether it failed for want of memory.
    #[pyo3(get)]
    has_no_room: bool,
    /// The estimated error of its states, where the scene asks for it.
    #[pyo3(get)]
    state_error: Option<ErrorOfStates>,
    /// Why there is no such estimate.
    #[pyo3(get)]
    no_state_error: Option<String>,
    /// Why it stopped or failed.
    #[pyo3(get)]
    message: String,
    /// The last time.
    #[pyo3(get)]
    time: f64,
    /// Steps made.
    #[pyo3(get)]
    steps: u64,
    /// Seconds of integration.
    #[pyo3(get)]
    wall_seconds: f64,
    /// Evaluations of the solver.
    #[pyo3(get)]
    evaluations: u64,
    /// Name, initial value and largest deviation of each invariant.
    #[pyo3(get)]
    invariants: Vec<(String, f64, f64)>,
    /// Times and states of the crossings of each event that was looked for.
    #[pyo3(get)]
    events: Vec<(Py<PyArray1<f64>>, Py<PyArray2<f64>>)>,
    /// The scene's text.
    #[pyo3(get)]
    scene: String,
    /// The method in words.
    #[pyo3(get)]
    method: Vec<String>,
    /// Which of the events ended the run, where one did.
    #[pyo3(get)]
    ended_by: Option<usize>,
    /// Advice: changes to make in the scene.
    #[pyo3(get)]
    advice: Vec<String>,
    /// Whether the motion is regular or chaotic, in words, where MEGNO is recorded.
    #[pyo3(get)]
    motion: Option<String>,
    page: ReportData,
}

impl Recorded {
    /// Results of a run that records so many coordinates, of a scene with this text and method.
    pub fn new(
        py: Python<'_>,
        coordinates: usize,
        (scene, method): (String, Vec<String>),
        (recorded, error): (run::Recorded, Option<Result<StateError, NoStateError>>),
    ) -> PyResult<Self> {
        let run::Recorded {
            report,
            columns,
            samples,
            crossings,
            windows_columns,
            windows,
            has_no_room,
            events,
            ended_by,
            page,
        } = recorded;
        let dimension = report.final_state.len();
        let events = events.into_iter().map(|found| {
            let times = found.iter().map(|crossing| crossing.time).collect();
            let states: Vec<f64> = found
                .into_iter()
                .flat_map(|crossing| crossing.state)
                .collect();
            let times = PyArray1::from_vec(py, times).unbind();
            PyResult::Ok((times, table(py, states, dimension)?))
        });
        let width = columns.len();
        let crossings = crossings.map(|rows| table(py, rows, width)).transpose()?;
        Ok(Self {
            samples: table(py, samples, width)?,
            crossings,
            windows: table(py, windows, windows_columns.len())?,
            events: events.collect::<PyResult<_>>()?,
            ended_by,
            scene,
            method,
            columns,
            coordinates,
            windows_columns,
            final_state: PyArray1::from_slice(py, &report.final_state).unbind(),
            outcome: report.outcome.word(),
            has_no_room,
            no_state_error: (error.as_ref())
                .and_then(|error| error.as_ref().err())
                .map(ToString::to_string),
            state_error: error.and_then(Result::ok).map(as_tuple),
            message: message(&report),
            time: report.time,
            steps: report.steps,
            wall_seconds: report.wall_seconds,
            evaluations: report.statistics.evaluations,
            invariants: report
                .invariants
                .iter()
                .map(|one| (one.name.clone(), one.initial, one.maximum))
                .collect(),
            advice: report
                .advice
                .iter()
                .map(|one| format!("{}; {}", one.message, one.change))
                .collect(),
            motion: report.chaos.map(|chaos| chaos.text()),
            page,
        })
    }
}

/// Why a run ended before its end.
fn message(report: &RunReport) -> String {
    match &report.outcome {
        RunOutcome::Done => String::new(),
        RunOutcome::Stopped(condition) => condition.clone(),
        RunOutcome::Interrupted => format!("interrupted after {} steps", report.steps),
        RunOutcome::Failed(failure) => format!(
            "step {} failed at t = {}: {}; {}",
            failure.step, failure.time, failure.message, failure.hint
        ),
    }
}

/// Rows one after the other, as an array without a copy.
pub(crate) fn table(py: Python<'_>, rows: Vec<f64>, width: usize) -> PyResult<Py<PyArray2<f64>>> {
    let count = rows.len() / width;
    Ok(PyArray1::from_vec(py, rows)
        .reshape([count, width])?
        .unbind())
}

#[pymethods]
impl Recorded {
    /// The report of the run: a page that needs nothing else.
    fn page(&self) -> PyResult<String> {
        render_report(&self.page).map_err(|error| LeafwiseError::new_err(error.to_string()))
    }
}
