//! Subject of a job: whose scene is taken up, in which directory.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::manifest::{FilesRecord, Kind, REPORT, ShardRecord};
use leafwise_scene::compose::{ComposedRun, SceneChecks};
use leafwise_scene::document::SceneDocument;

/// Where a job is written and what is let pass.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The run directory.
    pub directory: PathBuf,
    /// Replaces the run that the directory holds.
    pub force: bool,
    /// Integrates a tensor that violates the Jacobi identity.
    pub allow_non_poisson: bool,
    /// The command that repeats this run, for the report.
    pub command: String,
    /// How often a checkpoint of a run is written: what a kill costs at most.
    pub checkpoint_every: Duration,
}

impl RunOptions {
    /// The usual [`checkpoint_every`](Self::checkpoint_every).
    pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

    /// Options of a job in a directory: nothing there is replaced, and nothing let pass.
    pub fn within(directory: impl Into<PathBuf>) -> Self {
        Self {
            directory: directory.into(),
            force: false,
            allow_non_poisson: false,
            command: String::new(),
            checkpoint_every: Self::CHECKPOINT_EVERY,
        }
    }

    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join(REPORT)
    }
}

/// Subject of a job, in values: all that its directory is opened and its manifest begun with.
pub struct JobSubject<'a> {
    /// One trajectory or many, or some of these.
    pub kind: Kind,
    /// The scene as run.
    pub document: &'a SceneDocument,
    /// The run whose system and method the manifest describes.
    pub run: &'a ComposedRun,
    /// The checks of its system.
    pub checks: &'a SceneChecks,
    /// Record of the files that are read.
    pub files: Option<FilesRecord>,
    /// Which members or settings, of a shard.
    pub shard: Option<ShardRecord>,
    /// The directories of shards that are joined. A directory that has not come to its end is then begun anew.
    pub sources: Vec<&'a Path>,
    /// Where it is written.
    pub options: &'a RunOptions,
}
