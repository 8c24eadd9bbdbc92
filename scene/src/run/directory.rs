//! The run directory: start afresh, resume, or refuse.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::checkpoint;
use super::difference::{changed_keys, listed};
use super::error::RunError;
use super::manifest::{self, Kind, Manifest, PROGRAM_VERSION, PluginRecord};
use super::samples;
use crate::document::SceneDocument;
use crate::ensemble::store;

/// The scene as run.
pub(crate) const SCENE: &str = "scene.toml";
/// Maxima of the invariants' deviations over windows.
pub(crate) const WINDOWS: &str = "windows.csv";
/// The last state, where samples do not hold it.
pub(crate) const FINAL_STATE: &str = "final_state.bin";
/// The page to open.
pub(crate) const REPORT: &str = "report.html";
/// What the members of an ensemble are reduced to, and the first of those that failed.
pub(crate) const STATISTICS: &str = "statistics.csv";
pub(crate) const FAILURES: &str = "failures.csv";
/// Held by the program that writes.
const LOCK: &str = ".lock";

/// `runs/` and the scene file's name without its extension.
pub fn default_directory(document: &SceneDocument) -> PathBuf {
    if let Some(out) = &document.run.out {
        return PathBuf::from(&out.value);
    }
    Path::new("runs").join(stem(document))
}

/// The scene file's name without its extension.
pub(crate) fn stem(document: &SceneDocument) -> String {
    let stem = Path::new(&document.name).file_stem();
    stem.map_or_else(
        || "scene".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// A run that wants a directory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked<'a> {
    /// One trajectory or many.
    pub kind: Kind,
    /// The scene as run.
    pub scene: &'a str,
    /// The libraries it uses.
    pub plugins: &'a [PluginRecord],
}

/// A directory that this program writes to, until dropped.
pub(crate) struct RunDirectory {
    /// Where it is.
    pub path: PathBuf,
    /// When the unfinished run that it holds was begun.
    pub unfinished: Option<String>,
    /// The lock ends with the file.
    _lock: File,
}

impl RunDirectory {
    /// Takes hold of `path` for a run.
    ///
    /// A directory without a run in it must be empty. With `force` the run it holds is removed:
    /// only the files that a run writes.
    pub fn open(path: &Path, run: &Asked<'_>, force: bool) -> Result<Self, RunError> {
        let is_ours = path.join(LOCK).exists() || path.join(manifest::FILE).exists();
        let is_empty = match fs::read_dir(path) {
            Ok(mut entries) => entries.next().is_none(),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => true,
            Err(error) => return Err(RunError::io(path)(error)),
        };
        if !is_ours && !is_empty {
            return Err(RunError::Foreign {
                directory: path.to_owned(),
            });
        }
        let stored = Manifest::read(path);
        if let Some(stored) = stored.as_ref().filter(|_| !force) {
            refuse_other(path, stored, run)?;
        }
        fs::create_dir_all(path).map_err(RunError::io(path))?;
        let lock_path = path.join(LOCK);
        let lock = File::create(&lock_path).map_err(RunError::io(&lock_path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(RunError::Busy {
                    directory: path.to_owned(),
                });
            }
            Err(TryLockError::Error(error)) => return Err(RunError::io(&lock_path)(error)),
        }
        let unfinished = match stored {
            Some(stored) if !force => Some(stored.started),
            _ => None,
        };
        if unfinished.is_none() {
            remove_run(path)?;
        }
        Ok(Self {
            path: path.to_owned(),
            unfinished,
            _lock: lock,
        })
    }
}

/// Refuses a directory whose run has ended or is of another scene; other comments and other
/// spaces are the same scene.
fn refuse_other(path: &Path, stored: &Manifest, run: &Asked<'_>) -> Result<(), RunError> {
    let Asked {
        kind,
        scene,
        plugins,
    } = *run;
    let directory = path.to_owned();
    if stored.kind != kind {
        let other = stored.kind.words();
        return Err(RunError::OtherKind { directory, other });
    }
    if !stored.is_unfinished() {
        let ended = if stored.outcome == "failed" {
            "failed"
        } else {
            "finished"
        };
        return Err(RunError::Ended { directory, ended });
    }
    if stored.version != PROGRAM_VERSION {
        return Err(RunError::VersionChanged {
            directory,
            version: stored.version.clone(),
        });
    }
    let file = path.join(SCENE);
    let before = fs::read_to_string(&file).map_err(RunError::resuming(&file))?;
    let Some(changes) = changed_keys(&before, scene) else {
        return Err(RunError::Damaged {
            file,
            reason: "it is not a whole scene".to_owned(),
        });
    };
    if !changes.is_empty() {
        return Err(RunError::SceneChanged {
            directory,
            difference: listed(changes),
        });
    }
    let is_used = |before: &&PluginRecord| plugins.iter().any(|now| now.sha256 == before.sha256);
    if let Some(changed) = stored.plugins.iter().find(|before| !is_used(before)) {
        return Err(RunError::PluginChanged {
            directory,
            plugin: changed.path.clone(),
            sha256: changed.sha256.clone(),
        });
    }
    Ok(())
}

/// Removes the files that a run writes, and nothing else.
fn remove_run(path: &Path) -> Result<(), RunError> {
    for name in [
        manifest::FILE,
        checkpoint::FILE,
        SCENE,
        samples::FILE,
        WINDOWS,
        FINAL_STATE,
        REPORT,
        STATISTICS,
        FAILURES,
        store::CSV,
        store::BINARY,
    ] {
        let file = path.join(name);
        match fs::remove_file(&file) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(RunError::io(file)(error));
            }
            _ => {}
        }
    }
    Ok(())
}
