//! Results of a sweep.

use std::fs;

use leafwise::run::sweep::{SweepEnding, SweepReport};
use pyo3::prelude::*;

use crate::error::LeafwiseError;

/// A sweep that has ended.
#[pyclass(frozen, module = "leafwise._leafwise")]
pub(crate) struct Sweep {
    /// The table, as CSV.
    #[pyo3(get)]
    table: String,
    /// The end of the program's manifest, as JSON.
    #[pyo3(get)]
    ending: String,
    /// The report.
    #[pyo3(get)]
    page: String,
}

impl Sweep {
    /// Reads the directory of a sweep.
    pub fn read(report: &SweepReport) -> PyResult<Self> {
        let ending = serde_json::to_string(&SweepEnding::new(report));
        let ending = ending.map_err(|error| LeafwiseError::new_err(error.to_string()))?;
        Ok(Self {
            table: fs::read_to_string(report.table())?,
            page: fs::read_to_string(report.report())?,
            ending,
        })
    }
}
