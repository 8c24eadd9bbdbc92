//! Ensembles and sweeps in directories: whole or in shards, computed or joined from shards.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use leafwise::run::ensemble::{ComposedEnsemble, EnsembleJob, EnsembleReport, Workforce};
use leafwise::run::shards::{Portion, Shard, Shards, Whole};
use leafwise::run::sweep::{Settings, SweepJob, SweepReport, compose_sweep};
use leafwise::run::{RunOptions, RunOutcome, perform};
use leafwise_cli::failure::Failure;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::error::{LeafwiseError, exception};
use crate::progress::PythonProgress;
use crate::read::Read;

/// Items that are made, and where they come from: all or a shard I of N, computed or joined from shards.
pub(crate) struct Origin {
    place: Option<(u64, u64)>,
    shards: Option<Shards>,
}

fn failed(error: impl Into<Failure>) -> PyErr {
    exception(&error.into())
}

impl Origin {
    /// A shard at a place, or all; joined from the shards in a folder, if one is given.
    pub fn find(place: Option<(u64, u64)>, folder: Option<PathBuf>) -> PyResult<Self> {
        let shards = folder.map(|folder| Shards::find(&[folder]));
        let shards = shards.transpose().map_err(failed)?;
        Ok(Self { place, shards })
    }

    /// Those of so many items.
    fn portion(&self, whole: Whole, count: u64) -> PyResult<Portion<'_>> {
        match (self.place, &self.shards) {
            (None, None) => Ok(Portion::default()),
            (None, Some(shards)) => Portion::merged(shards).map_err(failed),
            (Some(_), Some(shards)) => Portion::joined(shards).map_err(failed),
            (Some((number, of)), None) => {
                let shard = Shard::of(whole, number, of, count);
                let shard = shard.map_err(|error| LeafwiseError::new_err(error.to_string()))?;
                Ok(Portion::computed(Some(&shard)))
            }
        }
    }
}

/// Raises Ctrl-C where it has ended a job.
pub(crate) fn unless_interrupted(outcome: &RunOutcome) -> PyResult<()> {
    match outcome {
        RunOutcome::Interrupted => Err(PyKeyboardInterrupt::new_err(())),
        _ => Ok(()),
    }
}

impl Read {
    /// Makes an ensemble of the scene, or a part of it.
    pub fn make(
        &self,
        ensemble: &ComposedEnsemble,
        origin: &Origin,
        options: &RunOptions,
        workforce: Workforce,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<EnsembleReport> {
        let portion = origin.portion(Whole::Members, ensemble.population.members())?;
        let mut told = PythonProgress::new(progress, self.functions.as_ref());
        let job = EnsembleJob::new(&self.document, ensemble, portion, options, workforce);
        let report = job.and_then(|job| perform(&job, &mut told));
        match told.into_raised() {
            Some(error) => Err(error),
            None => report.map_err(failed),
        }
    }

    /// Makes the sweep of the scene, or a part of it.
    pub fn sweep(
        &self,
        origin: &Origin,
        options: &RunOptions,
        threads: NonZeroUsize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<SweepReport> {
        let (document, registry) = (&self.document, &self.registry);
        let settings = Settings::of(document).map_err(failed)?;
        let count = settings.count();
        let portion = origin.portion(Whole::Settings, count)?;
        let items = match (&origin.shards, portion.shard()) {
            (Some(_), _) => 0..0,
            (None, Some(shard)) => shard.items(),
            (None, None) => 0..count,
        };
        let allow = options.allow_non_poisson;
        let sweep = compose_sweep(document, registry, settings, items, allow, &mut |_, _| ())
            .map_err(failed)?;
        let mut told = PythonProgress::new(progress, self.functions.as_ref());
        let job = SweepJob::new(document, &sweep, portion, options, threads);
        let report = perform(&job, &mut told).map_err(failed)?;
        told.check()?;
        Ok(report)
    }
}
