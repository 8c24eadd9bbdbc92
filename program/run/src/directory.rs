//! The run directory: start afresh, resume, or refuse.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::checkpoint;
use super::difference::{Change, changed_keys, listed};
use super::error::RunError;
use super::manifest::{
    self, FilesRecord, Kind, Manifest, PROGRAM_VERSION, PluginRecord, ShardRecord,
};
use super::{samples, states};
use crate::ensemble::store;
use crate::shards::Whole;
use leafwise_scene::document::SceneDocument;

/// The scene as run.
pub(crate) const SCENE: &str = "scene.toml";
/// Maxima of the invariants' deviations over windows.
pub(crate) const WINDOWS: &str = "windows.csv";
/// The page to open.
pub(crate) const REPORT: &str = "report.html";
/// Tables of an ensemble: statistics of its members, and the first of those that failed.
pub(crate) const STATISTICS: &str = "statistics.csv";
pub(crate) const FAILURES: &str = "failures.csv";
/// How many of them the scene's condition has ended, against time.
pub(crate) const LOSSES: &str = "losses.csv";
/// A row for each setting of a sweep.
pub(crate) const SWEEP: &str = "sweep.csv";
/// Held by the program that writes.
const LOCK: &str = ".lock";

/// `runs/` and the scene file's name without its extension.
pub fn default_directory(document: &SceneDocument) -> PathBuf {
    if let Some(out) = &document.run.out {
        return PathBuf::from(&out.value);
    }
    Path::new("runs").join(stem(document))
}

/// The scene file's name without its extension; `scene` where that is no name for a folder.
pub(crate) fn stem(document: &SceneDocument) -> String {
    let stem = Path::new(&document.name).file_stem().unwrap_or_default();
    match stem.to_string_lossy().as_ref() {
        "" | "." | ".." => "scene".to_owned(),
        stem => stem.to_owned(),
    }
}

/// A run that wants a directory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunRequest<'a> {
    /// One trajectory or many.
    pub kind: Kind,
    /// The scene as run.
    pub scene: &'a str,
    /// The libraries it uses.
    pub plugins: &'a [PluginRecord],
    /// Record of the files that it read.
    pub files: Option<&'a FilesRecord>,
    /// Which members of an ensemble.
    pub shard: Option<ShardRecord>,
}

/// A run of the same scene and inputs that a directory holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Held {
    /// When it was begun.
    pub started: String,
    /// Whether it has come to its end.
    pub is_done: bool,
    /// Whether that end is where a condition stopped it.
    pub is_stopped: bool,
    /// Whether the number of steps is the same too.
    pub has_same_steps: bool,
}

/// A directory that this program writes to, until dropped.
pub(crate) struct RunDirectory {
    /// Where it is.
    pub path: PathBuf,
    /// The run that it holds, to be continued or told again.
    pub held: Option<Held>,
    /// The lock ends with the file.
    _lock: File,
}

impl RunDirectory {
    /// Takes hold of `path` for a run.
    ///
    /// A directory without the manifest of a run must be empty: nothing else tells that its files are
    /// ours. With `force` the run it holds is removed: only the files that a run of its kind writes.
    pub fn open(path: &Path, run: &RunRequest<'_>, force: bool) -> Result<Self, RunError> {
        // No path at all is the folder where the program runs.
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        if Manifest::read(path).is_none() && !holds_nothing(path)? {
            return Err(RunError::Foreign {
                directory: path.to_owned(),
            });
        }
        fs::create_dir_all(path).map_err(RunError::io(path))?;
        let lock = lock(path)?;
        let stored = Manifest::read(path);
        let held = match &stored {
            Some(stored) if !force => Some(held(path, stored, run)?),
            _ => None,
        };
        if let (Some(stored), None) = (&stored, &held) {
            remove_run(path, stored.kind)?;
        }
        Ok(Self {
            path: path.to_owned(),
            held,
            _lock: lock,
        })
    }
}

/// Whether a directory is absent, or has no more in it than a run that was killed before it had a
/// manifest.
fn holds_nothing(path: &Path) -> Result<bool, RunError> {
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(RunError::reading(path)(error)),
    };
    for entry in entries {
        let name = entry.map_err(RunError::reading(path))?.file_name();
        if name != LOCK && name != manifest::UNFINISHED_FILE {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Keeps other programs out until the file is dropped.
fn lock(path: &Path) -> Result<File, RunError> {
    let file = path.join(LOCK);
    let mut options = OpenOptions::new();
    let opened = options.write(true).create(true).truncate(false).open(&file);
    let lock = opened.map_err(RunError::io(&file))?;
    match lock.try_lock() {
        Ok(()) => Ok(lock),
        Err(TryLockError::WouldBlock) => Err(RunError::Busy {
            directory: path.to_owned(),
        }),
        Err(TryLockError::Error(error)) => Err(RunError::io(&file)(error)),
    }
}

/// The run of a directory, refused where it has failed or is another one. Other comments and other
/// spaces are the same scene; another number of steps, or another end, is the same run of one trajectory.
fn held(path: &Path, stored: &Manifest, run: &RunRequest<'_>) -> Result<Held, RunError> {
    let directory = path.to_owned();
    if stored.kind != run.kind {
        let other = stored.kind.words();
        return Err(RunError::OtherKind { directory, other });
    }
    let is_stopped = stored.outcome == "stopped";
    let is_done = is_stopped || stored.outcome == "done";
    if !is_done && !stored.is_unfinished() {
        return Err(RunError::Failed { directory });
    }
    if stored.version != PROGRAM_VERSION {
        return Err(RunError::VersionChanged {
            directory,
            version: stored.version.clone(),
        });
    }
    let changes = changes(path, run.scene)?;
    let is_steps = |change: &Change| {
        let is_end = |key: &str| ["run.steps", "run.until"].contains(&key);
        run.kind == Kind::Run && change.key.as_deref().is_some_and(is_end)
    };
    let reasons = changes.iter().filter(|change| !is_steps(change));
    let reasons: Vec<Change> = reasons.cloned().collect();
    if !reasons.is_empty() {
        let difference = listed(&reasons);
        return Err(if is_done {
            RunError::Ended {
                directory,
                difference,
            }
        } else {
            RunError::SceneChanged {
                directory,
                difference,
            }
        });
    }
    if stored.shard != run.shard {
        let held = stored.shard.map_or([0, 0], |shard| shard.members);
        let items = match run.kind {
            Kind::SweepShard => Whole::Settings.items(),
            _ => Whole::Members.items(),
        };
        return Err(RunError::OtherShard {
            directory,
            items,
            held,
        });
    }
    let is_used =
        |before: &&PluginRecord| run.plugins.iter().any(|now| now.sha256 == before.sha256);
    if let Some(changed) = stored.plugins.iter().find(|before| !is_used(before)) {
        return Err(RunError::PluginChanged {
            directory,
            plugin: changed.path.clone(),
            sha256: changed.sha256.clone(),
        });
    }
    if let (Some(before), Some(now)) = (&stored.files, run.files)
        && before.sha256 != now.sha256
    {
        let files = now.paths.join(", ");
        return Err(RunError::FileChanged { directory, files });
    }
    Ok(Held {
        started: stored.started.clone(),
        is_done,
        is_stopped,
        has_same_steps: changes.is_empty(),
    })
}

/// Differences between the scene that a directory holds and another. There are none where the run was killed before it
/// had written any file but the manifest.
fn changes(path: &Path, scene: &str) -> Result<Vec<Change>, RunError> {
    let file = path.join(SCENE);
    let before = match fs::read_to_string(&file) {
        Err(error) if error.kind() == ErrorKind::NotFound && has_only_a_manifest(path) => {
            return Ok(Vec::new());
        }
        read => read.map_err(RunError::resuming(&file))?,
    };
    changed_keys(&before, scene).ok_or_else(|| RunError::Damaged {
        file,
        reason: "it is not a whole scene".to_owned(),
    })
}

fn has_only_a_manifest(path: &Path) -> bool {
    let files = files(Kind::Run)
        .chain(files(Kind::Ensemble))
        .chain(files(Kind::Sweep));
    let mut others = files.filter(|name| *name != manifest::FILE);
    !others.any(|name| path.join(name).exists())
}

/// The files that a run writes.
fn files(kind: Kind) -> impl Iterator<Item = &'static str> {
    let common = [manifest::FILE, checkpoint::FILE, SCENE, WINDOWS, REPORT];
    let own: &[&str] = match kind {
        Kind::Run => &[
            samples::FILE,
            samples::UNPUBLISHED,
            samples::SECTION,
            states::FILE,
            states::FINAL_STATE,
        ],
        Kind::Sweep | Kind::SweepShard => &[SWEEP],
        Kind::Ensemble | Kind::Shard => &[
            STATISTICS,
            FAILURES,
            LOSSES,
            samples::SECTION,
            store::CSV,
            store::BINARY,
            store::MATRIX,
        ],
    };
    common.into_iter().chain(own.iter().copied())
}

/// Removes the files that a run of a kind writes, and nothing else; the manifest last, which tells
/// whose they are.
fn remove_run(path: &Path, kind: Kind) -> Result<(), RunError> {
    let (first, last): (Vec<_>, Vec<_>) = files(kind).partition(|name| *name != manifest::FILE);
    for name in first.into_iter().chain(last) {
        let file = path.join(name);
        match fs::remove_file(&file) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(RunError::io(file)(error));
            }
            _ => {}
        }
    }
    Ok(())
}
