//! The entry of all jobs, which knows their kinds.

use crate::ensemble::EnsembleJob;
use crate::execute::RunJob;
use crate::job::{Job, Kind, names};
use crate::sweep::SweepJob;
use crate::{Progress, RunError};

/// Performs a job in its directory: a [`RunJob`], an [`EnsembleJob`] or a [`SweepJob`].
///
/// An unfinished job of the same scene is resumed, to the same bits as without interruption. One that has ended is told
/// of again, with nothing computed: files of its end that are not there are made anew.
///
/// # Errors
/// The directory's refusals, damaged shards that are joined, and failures of the file system.
pub fn perform<'a, J: Job<'a>>(
    job: &'a J,
    progress: &mut dyn Progress,
) -> Result<J::Report, RunError> {
    crate::job::perform(job, files, progress)
}

/// The files that jobs of a kind leave, beside those of every job.
fn files(kind: Kind) -> Vec<&'static str> {
    match kind {
        Kind::Run => names::<RunJob<'_>>(),
        Kind::Ensemble | Kind::Shard => names::<EnsembleJob<'_>>(),
        Kind::Sweep | Kind::SweepShard => names::<SweepJob<'_>>(),
    }
}
