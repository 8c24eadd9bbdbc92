//! Results of a sweep.

use std::fs;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use leafwise::core::Registry;
use leafwise::run::shards::{MergeError, Shard, Shards, Whole};
use leafwise::run::sweep::{
    Settings, SweepEnding, SweepReport, compose_sweep, join_sweep_shards, merge_sweep, run_sweep,
    run_sweep_shard,
};
use leafwise::run::{RunError, RunOptions, RunOutcome};
use leafwise::scene::SceneDocument;
use leafwise_cli::failure::Failure;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::error::{LeafwiseError, exception};
use crate::progress::PythonProgress;

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

/// A scene whose sweep is run.
pub(crate) struct AskedSweep<'a> {
    pub document: &'a SceneDocument,
    pub registry: &'a Registry,
    pub options: RunOptions,
}

fn failed(error: RunError) -> PyErr {
    exception(&Failure::from(error))
}

fn not_merged(error: MergeError) -> PyErr {
    exception(&Failure::from(error))
}

impl Sweep {
    /// Runs the settings, or joins shards of them.
    pub fn run(
        asked: &AskedSweep<'_>,
        shards: Option<PathBuf>,
        threads: NonZeroUsize,
        told: &mut PythonProgress<'_>,
    ) -> PyResult<Self> {
        let AskedSweep {
            document,
            registry,
            options,
        } = asked;
        let settings = Settings::of(document).map_err(|e| exception(&Failure::from(e)))?;
        let items = match &shards {
            None => 0..settings.count(),
            Some(_) => 0..0,
        };
        let allow = options.allow_non_poisson;
        let sweep = compose_sweep(document, registry, settings, items, allow, &mut |_, _| ())
            .map_err(failed)?;
        let report = match shards {
            Some(folder) => {
                let shards = Shards::find(&[folder]).map_err(not_merged)?;
                merge_sweep(document, &sweep, &shards, options).map_err(not_merged)?
            }
            None => run_sweep(document, &sweep, options, threads, told).map_err(failed)?,
        };
        told.check()?;
        Self::read(&report)
    }

    fn read(report: &SweepReport) -> PyResult<Self> {
        let ending = serde_json::to_string(&SweepEnding::new(report));
        let ending = ending.map_err(|error| LeafwiseError::new_err(error.to_string()))?;
        Ok(Self {
            table: fs::read_to_string(report.table())?,
            page: fs::read_to_string(report.report())?,
            ending,
        })
    }
}

/// Makes a shard: of settings, or of smaller shards.
pub(crate) fn sweep_shard(
    asked: &AskedSweep<'_>,
    (number, of): (u64, u64),
    shards: Option<PathBuf>,
    threads: NonZeroUsize,
    told: &mut PythonProgress<'_>,
) -> PyResult<()> {
    let AskedSweep {
        document,
        registry,
        options,
    } = asked;
    let settings = Settings::of(document).map_err(|e| exception(&Failure::from(e)))?;
    let shard = Shard::of(Whole::Settings, number, of, settings.count());
    let shard = shard.map_err(|error| LeafwiseError::new_err(error.to_string()))?;
    let items = match &shards {
        None => shard.items(),
        Some(_) => 0..0,
    };
    let allow = options.allow_non_poisson;
    let sweep = compose_sweep(document, registry, settings, items, allow, &mut |_, _| ())
        .map_err(failed)?;
    let report = match shards {
        Some(folder) => {
            let shards = Shards::find(&[folder]).map_err(not_merged)?;
            join_sweep_shards(document, &sweep, &shards, options).map_err(not_merged)?
        }
        None => {
            run_sweep_shard(document, &sweep, &shard, options, threads, told).map_err(failed)?
        }
    };
    told.check()?;
    match report.outcome {
        RunOutcome::Interrupted => Err(PyKeyboardInterrupt::new_err(())),
        _ => Ok(()),
    }
}
