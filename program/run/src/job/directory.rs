//! The run directory: start afresh, resume, or refuse.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::beginning::plugins;
use super::difference::{Change, changed_keys, listed};
use super::files::remove_parts;
use super::manifest::{self, CHECKPOINT, Kind, Manifest, PROGRAM_VERSION, PluginRecord, SCENE};
use super::shards::Whole;
use super::subject::JobSubject;
use crate::RunError;
use crate::replaced::UNFINISHED;
use leafwise_scene::document::SceneDocument;

/// Held by the program that writes.
const LOCK: &str = ".lock";

/// The files that jobs of a kind leave, beside those of every job.
pub type Files = fn(Kind) -> Vec<&'static str>;

/// The directory that the scene names, or else `runs/` and the scene file's name without its extension, behind it what
/// kind of job it is. Of a shard it is a folder of shards.
pub fn default_directory(document: &SceneDocument, kind: Kind) -> PathBuf {
    let ensemble = document.ensemble.as_ref();
    let sweep = document.sweep.as_ref();
    let (out, behind) = match kind {
        Kind::Run => (document.run.out.as_ref(), ""),
        Kind::Ensemble => (ensemble.and_then(|table| table.out.as_ref()), "-ensemble"),
        Kind::Shard => (None, "-shards"),
        Kind::Sweep => (sweep.and_then(|table| table.out.as_ref()), "-sweep"),
        Kind::SweepShard => (None, "-sweep-shards"),
    };
    if let Some(out) = out {
        return PathBuf::from(&out.value);
    }
    let stem = Path::new(&document.name).file_stem().unwrap_or_default();
    let stem = match stem.to_string_lossy().as_ref() {
        // No name for a folder.
        "" | "." | ".." => "scene".to_owned(),
        stem => stem.to_owned(),
    };
    Path::new("runs").join(stem + behind)
}

/// A run of the same scene and inputs that a directory holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
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
    /// Takes hold of the directory of a job.
    ///
    /// A directory without the manifest of a job must be empty: nothing else tells that its files are
    /// ours. With `force` the job it holds is removed: only the `files` that a job of its kind writes.
    pub fn open(subject: &JobSubject<'_>, files: Files) -> Result<Self, RunError> {
        // No path at all is the folder where the program runs.
        let path = match subject.options.directory.as_path() {
            path if path.as_os_str().is_empty() => Path::new("."),
            path => path,
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
            Some(stored) if !subject.options.force => Some(held(path, stored, subject, files)?),
            _ => None,
        };
        if let (Some(stored), None) = (&stored, &held) {
            remove(path, files(stored.kind))?;
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
fn held(
    path: &Path,
    stored: &Manifest,
    job: &JobSubject<'_>,
    files: Files,
) -> Result<Held, RunError> {
    let directory = path.to_owned();
    if stored.kind != job.kind {
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
    let changes = changes(path, &job.document.text, files)?;
    let is_steps = |change: &Change| {
        let is_end = |key: &str| ["run.steps", "run.until"].contains(&key);
        job.kind == Kind::Run && change.key.as_deref().is_some_and(is_end)
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
    if stored.shard != job.shard {
        let held = stored.shard.map_or([0, 0], |shard| shard.members);
        let items = match job.kind {
            Kind::SweepShard => Whole::Settings.items(),
            _ => Whole::Members.items(),
        };
        return Err(RunError::OtherShard {
            directory,
            items,
            held,
        });
    }
    let used = plugins(job.run);
    let is_used = |before: &&PluginRecord| used.iter().any(|now| now.sha256 == before.sha256);
    if let Some(changed) = stored.plugins.iter().find(|before| !is_used(before)) {
        return Err(RunError::PluginChanged {
            directory,
            plugin: changed.path.clone(),
            sha256: changed.sha256.clone(),
        });
    }
    if let (Some(before), Some(now)) = (&stored.files, &job.files)
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
fn changes(path: &Path, scene: &str, files: Files) -> Result<Vec<Change>, RunError> {
    let file = path.join(SCENE);
    let before = match fs::read_to_string(&file) {
        Err(error) if error.kind() == ErrorKind::NotFound && has_only_a_manifest(path, files) => {
            return Ok(Vec::new());
        }
        read => read.map_err(RunError::resuming(&file))?,
    };
    changed_keys(&before, scene).ok_or_else(|| RunError::Damaged {
        file,
        reason: "it is not a whole scene".to_owned(),
    })
}

fn has_only_a_manifest(path: &Path, files: Files) -> bool {
    let kinds = [Kind::Run, Kind::Ensemble, Kind::Sweep];
    let mut names = kinds.into_iter().flat_map(files).chain(COMMON);
    !names.any(|name| path.join(name).exists())
}

/// Files of every job beside the manifest.
const COMMON: [&str; 2] = [CHECKPOINT, SCENE];

/// Removes the files that a job leaves, and nothing else; the manifest last, which tells whose they are. From the first
/// on it says that the job is unfinished: whoever is killed in between leaves nothing that looks whole.
fn remove(path: &Path, names: Vec<&'static str>) -> Result<(), RunError> {
    manifest::unfinish(path)?;
    for name in names.into_iter().chain(COMMON).chain([manifest::FILE]) {
        let file = path.join(name);
        for file in [file.with_extension(UNFINISHED), file] {
            match fs::remove_file(&file) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(RunError::io(file)(error));
                }
                _ => {}
            }
        }
    }
    remove_parts(path).map_err(RunError::io(path))
}
