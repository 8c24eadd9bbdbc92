//! Why a run could not be started or kept on disk.

use std::io;
use std::path::{Path, PathBuf};

use leafwise_core::BuildError;
use thiserror::Error;

use super::room::NoRoom;
use leafwise_report::ReportError;
use leafwise_scene::compose::Refusal;

/// Why a run could not be started or kept on disk. A numerical failure is not one of these: it is
/// an outcome, [`RunOutcome::Failed`](super::RunOutcome::Failed).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The tensor is not Poisson, or a Casimir is not one.
    #[error("{0}")]
    Refused(Refusal),
    /// The directory holds a run that has failed.
    #[error(
        "{} holds a run that has failed; run again with --force to replace it, or with --out DIR \
         to write elsewhere",
        directory.display()
    )]
    Failed {
        /// The run directory.
        directory: PathBuf,
    },
    /// The directory holds a finished run of another scene.
    #[error(
        "{} holds a run that has finished, of a different scene:\n{difference}\nrun again with --force \
         to replace it, or with --out DIR to write elsewhere",
        directory.display()
    )]
    Ended {
        /// The run directory.
        directory: PathBuf,
        /// The keys that differ, each with the stored value and the given one.
        difference: String,
    },
    /// The directory holds a run that has gone further than the scene asks.
    #[error(
        "{} holds a run of the same scene of {made} steps, more than the {asked} requested; write \
         elsewhere with --out DIR, or replace it with --force",
        directory.display()
    )]
    Shortened {
        /// The run directory.
        directory: PathBuf,
        /// The steps it has made.
        made: u64,
        /// The steps of the scene.
        asked: u64,
    },
    /// The directory holds a run that has gone further in time than the scene asks.
    #[error(
        "{} holds a run of the same scene that has reached t = {reached:?}, beyond the requested t = {asked:?}; write \
         elsewhere with --out DIR, or replace it with --force",
        directory.display()
    )]
    Beyond {
        /// The run directory.
        directory: PathBuf,
        /// The time it has come to.
        reached: f64,
        /// The time of the scene.
        asked: f64,
    },
    /// The directory holds an unfinished run of another scene.
    #[error(
        "{} holds an unfinished run of a different scene:\n{difference}\nundo the change to resume \
         it, or run again with --force to replace it, or with --out DIR to write elsewhere",
        directory.display()
    )]
    SceneChanged {
        /// The run directory.
        directory: PathBuf,
        /// The keys that differ, each with the stored value and the given one.
        difference: String,
    },
    /// The directory holds an unfinished run of another version of the program.
    #[error(
        "{} was begun by version {version}, which may round differently; run again with --force \
         to replace it, or with --out DIR to write elsewhere",
        directory.display()
    )]
    VersionChanged {
        /// The run directory.
        directory: PathBuf,
        /// The version that began it.
        version: String,
    },
    /// The unfinished run was begun with another file of a plugin.
    #[error(
        "{} holds a run begun with another {} (sha256 {} then); continuing it would mix the two; \
         use --force to start afresh",
        directory.display(), plugin.display(), sha256.get(..12).unwrap_or(sha256)
    )]
    PluginChanged {
        /// The run directory.
        directory: PathBuf,
        /// The library.
        plugin: PathBuf,
        /// The hash of the file that began the run.
        sha256: String,
    },
    /// A file of values has changed since the run began.
    #[error(
        "{} holds a run begun with other numbers in {files}; continuing it would mix the two: \
         run again with --force to replace it, or with --out DIR to write elsewhere",
        directory.display()
    )]
    FileChanged {
        /// The run directory.
        directory: PathBuf,
        /// The files that the scene reads.
        files: String,
    },
    /// The directory holds a run of one trajectory where an ensemble is asked for, or the reverse.
    #[error(
        "{} holds {other}; write elsewhere with --out DIR, or replace it with --force",
        directory.display()
    )]
    OtherKind {
        /// The run directory.
        directory: PathBuf,
        /// Kind of run that it holds, in words.
        other: &'static str,
    },
    /// The directory holds other members of the ensemble, or other settings of the sweep.
    #[error(
        "{} holds the {} {} to {}, not those requested; write elsewhere with --out DIR, or replace it with --force",
        directory.display(), items, held[0], held[1].saturating_sub(1)
    )]
    OtherShard {
        /// The run directory.
        directory: PathBuf,
        /// `members` or `settings`.
        items: &'static str,
        /// The first member and the one behind the last.
        held: [u64; 2],
    },
    /// The directory holds something else.
    #[error(
        "{} exists and is not a run directory: it holds files, and no readable manifest.json of a run; choose another with --out DIR",
        directory.display()
    )]
    Foreign {
        /// The directory.
        directory: PathBuf,
    },
    /// Another process writes to the directory.
    #[error("another program is writing to {}; wait for it, or use --out DIR", directory.display())]
    Busy {
        /// The run directory.
        directory: PathBuf,
    },
    /// A file of an unfinished run that cannot be continued.
    #[error(
        "{} cannot be resumed from: {reason}; run again with --force to start over, or with --out DIR \
         to keep what is there",
        file.display()
    )]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Reason why it cannot be resumed from.
        reason: String,
    },
    /// A file of a shard that is not as it was written.
    #[error(
        "{} is damaged: {reason}; make that shard again with --force, or remove its folder",
        file.display()
    )]
    DamagedShard {
        /// The file.
        file: PathBuf,
        /// Reason why it is refused.
        reason: String,
    },
    /// Shards are joined into the directory of one of them.
    #[error("{} is one of the shards that are joined: write elsewhere with --out DIR", directory.display())]
    IntoShard {
        /// The directory.
        directory: PathBuf,
    },
    /// A file that a finished run has left is another one now.
    #[error(
        "{} differs from what was written: it was changed since, or damaged; remove it and run the same command \
         again, or write elsewhere with --out DIR",
        file.display()
    )]
    Changed {
        /// The file.
        file: PathBuf,
    },
    /// A file of an unfinished run in another format than this version of the program reads.
    #[error(
        "{} is of format {found}, and this version of leafwise reads format {read}: finish the run with \
         the version that began it, or run again with --force to start over, or with --out DIR to keep \
         what is there",
        file.display()
    )]
    Format {
        /// The file.
        file: PathBuf,
        /// The digit of its format.
        found: char,
        /// The digit of the format that is read.
        read: char,
    },
    /// Reading failed.
    #[error("cannot read {}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Writing failed.
    #[error("cannot write {}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Writing failed in the midst of a run; what was recorded up to the last checkpoint is on disk.
    #[error(
        "cannot write {}: {source}; the run is kept in {} as of its last checkpoint: once there is \
         space, the same command continues from there",
        file.display(), directory.display()
    )]
    Kept {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: io::Error,
        /// The run directory.
        directory: PathBuf,
    },
    /// There is no memory for the samples.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// An observable without code.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The report could not be drawn.
    #[error(transparent)]
    Report(#[from] ReportError),
}

impl RunError {
    /// For `map_err` on opening a file that an unfinished run must have.
    pub(crate) fn resuming(file: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let file = file.into();
        move |source| {
            if source.kind() == io::ErrorKind::NotFound {
                let reason = "it is missing".to_owned();
                Self::Damaged { file, reason }
            } else {
                Self::Read { file, source }
            }
        }
    }

    /// For `map_err` on reading a file.
    pub(crate) fn reading(file: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let file = file.into();
        move |source| Self::Read { file, source }
    }

    /// For `map_err` on writing a file.
    pub(crate) fn io(file: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let file = file.into();
        move |source| Self::Io { file, source }
    }

    /// An error of the file system, after a checkpoint was written to `directory`.
    pub(super) fn with_a_checkpoint(self, directory: &Path) -> Self {
        match self {
            Self::Io { file, source } => Self::Kept {
                file,
                source,
                directory: directory.to_owned(),
            },
            other => other,
        }
    }

    /// An error at a file of a shard that is to be joined: one from which it could not go on.
    pub(crate) fn of_shard(self) -> Self {
        match self {
            Self::Damaged { file, reason } => Self::DamagedShard { file, reason },
            Self::Format { file, found, .. } => Self::DamagedShard {
                file,
                reason: format!(
                    "its checkpoint is of format {found}, of another version of the program"
                ),
            },
            other => other,
        }
    }

    /// Whether the command line asks for something that the directory's content forbids.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Failed { .. }
                | Self::Ended { .. }
                | Self::Shortened { .. }
                | Self::Beyond { .. }
                | Self::SceneChanged { .. }
                | Self::VersionChanged { .. }
                | Self::PluginChanged { .. }
                | Self::FileChanged { .. }
                | Self::OtherShard { .. }
                | Self::Foreign { .. }
                | Self::OtherKind { .. }
                | Self::Busy { .. }
                | Self::Damaged { .. }
                | Self::DamagedShard { .. }
                | Self::IntoShard { .. }
                | Self::Changed { .. }
                | Self::Format { .. }
        )
    }
}
