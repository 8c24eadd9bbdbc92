//! Results of an ensemble, as arrays.

use std::fs;
use std::path::Path;

use leafwise::run::ensemble::{ComposedEnsemble, EnsembleEnding, EnsembleReport};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::error::LeafwiseError;
use crate::recorded::table;

/// The words of a member's end, by their number in [`Ensemble::outcomes`].
const OUTCOMES: [&str; 3] = ["done", "stopped", "failed"];

/// An ensemble that has ended.
#[pyclass(frozen, module = "leafwise._leafwise")]
pub(crate) struct Ensemble {
    /// The columns of `members` behind the time, where a condition ends members: parameters, coordinates, observables, initial
    /// coordinates, invariants' drifts.
    #[pyo3(get)]
    parameters: Vec<String>,
    #[pyo3(get)]
    variables: Vec<String>,
    #[pyo3(get)]
    observables: Vec<String>,
    #[pyo3(get)]
    invariants: Vec<String>,
    /// Whether `members` has a column of times.
    #[pyo3(get)]
    has_times: bool,
    /// The time at the end.
    #[pyo3(get)]
    time: f64,
    /// A row for each member.
    #[pyo3(get)]
    members: Py<PyArray2<f64>>,
    /// How each has ended: 0 done, 1 stopped, 2 failed.
    #[pyo3(get)]
    outcomes: Py<PyArray1<u8>>,
    /// Member, time, recorded coordinates and observables of each crossing of the section.
    #[pyo3(get)]
    crossings: Option<Py<PyArray2<f64>>>,
    /// Reductions over the members: the end of the program's manifest, as JSON.
    #[pyo3(get)]
    ending: String,
    /// Advice: changes to make in the scene.
    #[pyo3(get)]
    advice: Vec<String>,
    /// The report.
    #[pyo3(get)]
    page: String,
}

/// Contents of an ensemble's directory, without arrays of Python.
pub(crate) struct Left {
    members: Vec<f64>,
    outcomes: Vec<u8>,
    crossings: Option<Vec<f64>>,
    page: String,
    ending: String,
}

impl Left {
    /// Reads a directory.
    pub fn read(ensemble: &ComposedEnsemble, report: &EnsembleReport) -> PyResult<Self> {
        let directory = &report.directory;
        let (mut members, mut outcomes) = (Vec::new(), Vec::new());
        for line in text(&directory.join("final_states.csv"))?.lines().skip(1) {
            let mut cells = line.split(',').skip(1);
            let word = cells.next().unwrap_or_default();
            outcomes.extend(
                (0..)
                    .zip(OUTCOMES)
                    .find(|(_, w)| *w == word)
                    .map(|(k, _)| k),
            );
            numbers(cells, &mut members)?;
        }
        let crossings = match ensemble.run.plan.events.section {
            None => None,
            Some(_) => {
                let mut rows = Vec::new();
                for line in text(&directory.join("section.csv"))?.lines().skip(1) {
                    numbers(line.split(','), &mut rows)?;
                }
                Some(rows)
            }
        };
        let ending = serde_json::to_string(&EnsembleEnding::new(ensemble, report));
        Ok(Self {
            members,
            outcomes,
            crossings,
            page: text(&report.report())?,
            ending: ending.map_err(|error| LeafwiseError::new_err(error.to_string()))?,
        })
    }
}

fn text(file: &Path) -> PyResult<String> {
    let failed = |error| LeafwiseError::new_err(format!("cannot read {}: {error}", file.display()));
    fs::read_to_string(file).map_err(failed)
}

fn numbers<'a>(cells: impl Iterator<Item = &'a str>, rows: &mut Vec<f64>) -> PyResult<()> {
    for cell in cells {
        let value = cell.parse::<f64>();
        rows.push(value.map_err(|error| LeafwiseError::new_err(format!("{error}: {cell}")))?);
    }
    Ok(())
}

impl Ensemble {
    pub fn new(
        py: Python<'_>,
        ensemble: &ComposedEnsemble,
        report: &EnsembleReport,
        left: Left,
    ) -> PyResult<Self> {
        let plan = &ensemble.run.plan;
        let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect::<Vec<_>>();
        let declared = ensemble.run.system.parameters();
        let varied = ensemble.population.varied();
        let parameters: Vec<String> = varied.iter().map(|at| declared[*at].name.clone()).collect();
        let variables = ensemble.run.names();
        let observables = owned(ensemble.observables());
        let invariants = owned(ensemble.invariant_names());
        let has_times = plan.events.stop.is_some();
        let width = usize::from(has_times)
            + parameters.len()
            + 2 * variables.len()
            + observables.len()
            + invariants.len();
        let recorded = 2 + plan.states.width() + observables.len();
        let crossings = left.crossings.map(|rows| table(py, rows, recorded));
        Ok(Self {
            parameters,
            variables,
            observables,
            invariants,
            has_times,
            time: ensemble.end(),
            members: table(py, left.members, width)?,
            outcomes: PyArray1::from_vec(py, left.outcomes).unbind(),
            crossings: crossings.transpose()?,
            ending: left.ending,
            advice: (report.advice.iter())
                .map(|one| format!("{}; {}", one.message, one.change))
                .collect(),
            page: left.page,
        })
    }
}
