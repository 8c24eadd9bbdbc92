//! The shards of one ensemble or sweep, found in their directories.

use std::fmt;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::shard::{Shard, Whole};
use crate::RunError;
use crate::job::difference::{changed_keys, listed};
use crate::job::manifest::{CHECKPOINT, FILE as MANIFEST, Kind, Manifest, SCENE, ShardRecord};

/// The shards of one ensemble, by their members; or of a sweep, by their settings.
#[derive(Clone, Debug)]
pub struct Shards {
    whole: Whole,
    all: Vec<Found>,
}

/// A shard's directory.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// Where it is.
    pub directory: PathBuf,
    manifest: Manifest,
    record: ShardRecord,
    whole: Whole,
}

impl Found {
    fn of(directory: &Path, manifest: Manifest) -> Option<Self> {
        let whole = match manifest.kind {
            Kind::Shard => Whole::Members,
            Kind::SweepShard => Whole::Settings,
            _ => return None,
        };
        let record = manifest.shard?;
        Some(Self {
            whole,
            directory: directory.to_owned(),
            manifest,
            record,
        })
    }

    /// Its members or settings.
    pub fn items(&self) -> Range<u64> {
        self.record.members[0]..self.record.members[1]
    }

    fn is_done(&self) -> bool {
        self.manifest.outcome == "done"
    }

    /// The scene that it was made from.
    fn scene(&self) -> Result<String, RunError> {
        let file = self.directory.join(SCENE);
        let text = fs::read_to_string(&file);
        let text = text.map_err(|error| RunError::resuming(&file)(error).of_shard())?;
        match changed_keys(&text, &text) {
            Some(_) => Ok(text),
            None => Err(RunError::DamagedShard {
                file,
                reason: "it is not a whole scene".to_owned(),
            }),
        }
    }

    /// Refusal of a checkpoint that has not come as far.
    pub fn holds_fewer(&self) -> RunError {
        let items = self.whole.items();
        RunError::Damaged {
            file: self.directory.join(CHECKPOINT),
            reason: format!("it holds fewer {items} than its manifest says"),
        }
    }

    /// In what the two are not of one ensemble, their scenes apart.
    fn differs(&self, other: &Self) -> Option<String> {
        let (a, b) = (&self.manifest, &other.manifest);
        if self.whole != other.whole {
            return Some("one is of an ensemble, the other of a sweep".to_owned());
        }
        let plugins = |manifest: &Manifest| -> Vec<String> {
            let plugins = manifest.plugins.iter();
            plugins.map(|plugin| plugin.sha256.clone()).collect()
        };
        if a.version != b.version {
            let versions = format!("{} and {}", a.version, b.version);
            return Some(format!(
                "they are by versions {versions} of the program, which may round differently"
            ));
        }
        if plugins(a) != plugins(b) {
            return Some("they are by different files of a plugin".to_owned());
        }
        if a.files.as_ref().map(|files| &files.sha256)
            != b.files.as_ref().map(|files| &files.sha256)
        {
            return Some("the files that their scene reads held different numbers".to_owned());
        }
        if a.path != b.path {
            return Some(format!(
                "their steps are computed differently: {} and {}",
                a.path, b.path
            ));
        }
        let members = (self.record.ensemble, other.record.ensemble);
        (members.0 != members.1).then(|| {
            format!(
                "one is of {} {}, the other of {}",
                members.0,
                self.whole.items(),
                members.1
            )
        })
    }
}

/// Why shards are not joined.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MergeError {
    /// No shard stands there.
    #[error("{} is not a shard of an ensemble or a sweep, and holds none", directory.display())]
    NoShard {
        /// The directory.
        directory: PathBuf,
    },
    /// Two shards are of different ensembles or sweeps.
    #[error("{} and {} are not of one {}: {reason}", first.display(), other.display(), whole.word())]
    Other {
        /// Of what the first is.
        whole: Whole,
        /// The first of the shards.
        first: PathBuf,
        /// The one that differs.
        other: PathBuf,
        /// In what.
        reason: String,
    },
    /// The shards were made from another scene.
    #[error("{} was made from a different scene:\n{difference}", directory.display())]
    Scene {
        /// The first of the shards.
        directory: PathBuf,
        /// The keys that differ.
        difference: String,
    },
    /// Two shards hold the same members or settings.
    #[error(
        "{} and {} hold the same {}, {} to {}: name each shard once",
        first.display(), other.display(), whole.items(), items.start, items.end - 1
    )]
    Twice {
        /// Of what they are.
        whole: Whole,
        /// One of them.
        first: PathBuf,
        /// The other.
        other: PathBuf,
        /// Which of them.
        items: Range<u64>,
    },
    /// Members or settings are missing.
    #[error("{0}")]
    Missing(Missing),
    /// A directory or a file could not be read or written.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Members or settings that are missing, and the shards that make them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// Of what.
    pub whole: Whole,
    /// Which members or settings.
    pub items: Vec<Range<u64>>,
    /// The numbers of the shards that hold them, first and last, and how many shards there are.
    pub shards: Option<(Vec<[u64; 2]>, u64)>,
    /// Shards that have not come to their end.
    pub unfinished: Vec<PathBuf>,
}

/// Shards whose numbers are looked through for those that are missing.
const MOST_NUMBERED: u64 = 1_000_000;

/// Ranges that a message lists at most.
const MOST_LISTED: usize = 12;

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count: u64 = self.items.iter().map(|range| range.end - range.start).sum();
        let ranges = self.items.iter().take(MOST_LISTED);
        let ranges: Vec<String> = ranges
            .map(|range| format!("{} to {}", range.start, range.end - 1))
            .collect();
        let more = if self.items.len() > MOST_LISTED {
            ", …"
        } else {
            ""
        };
        write!(
            f,
            "{count} {} are missing: {}{more}",
            self.whole.items(),
            ranges.join(", ")
        )?;
        for directory in self.unfinished.iter().take(MOST_LISTED) {
            write!(f, "\n  {} has not come to its end", directory.display())?;
        }
        match &self.shards {
            Some((numbers, of)) => {
                let numbers: Vec<String> = numbers
                    .iter()
                    .map(|[first, last]| match first == last {
                        true => first.to_string(),
                        false => format!("{first}-{last}"),
                    })
                    .collect();
                write!(
                    f,
                    "\n  = help: run --shard I/{of} again for I in {0}; as a Slurm array, --array={0} with --shard slurm/{of}",
                    numbers.join(",")
                )
            }
            None if self.whole == Whole::Members => {
                write!(f, "\n  = help: run them with --members FROM..TO")
            }
            None => write!(
                f,
                "\n  = help: cut the sweep into shards that are all --shard I/N of one N"
            ),
        }
    }
}

impl Shards {
    /// The shards in these directories, each a shard or a folder of shards. Missing members are no error yet.
    ///
    /// # Errors
    /// [`MergeError`] where there is none, or they do not fit together.
    pub fn find(directories: &[PathBuf]) -> Result<Self, MergeError> {
        let mut found = Vec::new();
        for directory in directories {
            let before = found.len();
            match Manifest::read(directory) {
                Some(manifest) => found.extend(Found::of(directory, manifest)),
                None => {
                    for path in folders(directory).map_err(RunError::reading(directory))? {
                        match Manifest::read(&path) {
                            Some(manifest) => found.extend(Found::of(&path, manifest)),
                            None if path.join(MANIFEST).exists() => {
                                return Err(MergeError::Run(RunError::DamagedShard {
                                    file: path.join(MANIFEST),
                                    reason: "it is not a manifest of this program".to_owned(),
                                }));
                            }
                            None => {}
                        }
                    }
                }
            }
            if found.len() == before {
                return Err(MergeError::NoShard {
                    directory: directory.clone(),
                });
            }
        }
        found.sort_by(|a, b| {
            (a.record.members, &a.directory).cmp(&(b.record.members, &b.directory))
        });
        found.dedup_by(|a, b| is_same(&a.directory, &b.directory));
        Self::of_one(found)
    }

    fn of_one(found: Vec<Found>) -> Result<Self, MergeError> {
        let Some(first) = found.first() else {
            return Err(MergeError::NoShard {
                directory: PathBuf::new(),
            });
        };
        let text = first.scene()?;
        for other in &found[1..] {
            let reason = match first.differs(other) {
                Some(reason) => Some(reason),
                None => {
                    let own = other.scene()?;
                    let changes = match own == text {
                        true => None,
                        false => changed_keys(&text, &own),
                    };
                    let changes = changes.filter(|changes| !changes.is_empty());
                    changes.map(|changes| format!("their scenes differ:\n{}", listed(&changes)))
                }
            };
            if let Some(reason) = reason {
                return Err(MergeError::Other {
                    whole: first.whole,
                    first: first.directory.clone(),
                    other: other.directory.clone(),
                    reason,
                });
            }
        }
        Ok(Self {
            whole: first.whole,
            all: found,
        })
    }

    /// Their directories.
    pub(crate) fn directories(&self) -> Vec<&Path> {
        self.all
            .iter()
            .map(|shard| shard.directory.as_path())
            .collect()
    }

    /// The scene that they were made from, in the first of their directories.
    pub fn scene(&self) -> PathBuf {
        self.all[0].directory.join(SCENE)
    }

    /// Refuses a scene that they were not made from.
    ///
    /// # Errors
    /// [`MergeError::Scene`].
    pub fn check_scene(&self, text: &str) -> Result<(), MergeError> {
        match changed_keys(&self.all[0].scene()?, text) {
            Some(changes) if !changes.is_empty() => Err(MergeError::Scene {
                directory: self.all[0].directory.clone(),
                difference: listed(&changes),
            }),
            _ => Ok(()),
        }
    }

    /// Name of the scene's file.
    pub fn scene_name(&self) -> &str {
        &self.all[0].manifest.scene
    }

    /// Of what they are.
    pub fn whole(&self) -> Whole {
        self.whole
    }

    /// Those that have come to their end, in the order of what they hold.
    pub(crate) fn done(&self) -> impl Iterator<Item = &Found> {
        self.all.iter().filter(|shard| shard.is_done())
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Refuses shards that hold something twice, or not all of them.
    pub(crate) fn check_whole(&self) -> Result<(), MergeError> {
        self.check_all_of(0..self.all[0].record.ensemble)
    }

    /// The shard that they make together, without gaps.
    ///
    /// # Errors
    /// As [`check_whole`](Self::check_whole), of what lies between the first and the last.
    pub(crate) fn together(&self) -> Result<Shard, MergeError> {
        let bounds = self.all.iter().map(|shard| shard.record.members);
        let end = bounds.map(|[_, end]| end).max().unwrap_or(0);
        let items = self.all[0].record.members[0]..end;
        self.check_all_of(items.clone())?;
        Ok(Shard::joined(
            self.whole,
            items,
            self.all[0].record.ensemble,
        ))
    }

    fn check_all_of(&self, items: Range<u64>) -> Result<(), MergeError> {
        let (done, unfinished): (Vec<&Found>, Vec<&Found>) =
            self.all.iter().partition(|shard| shard.is_done());
        let mut absent = Vec::new();
        let mut last: Option<&Found> = None;
        let mut next = items.start;
        for &shard in done.iter().filter(|shard| !shard.items().is_empty()) {
            let members = shard.items();
            if let Some(last) = last.filter(|_| members.start < next) {
                return Err(MergeError::Twice {
                    whole: self.whole,
                    first: last.directory.clone(),
                    other: shard.directory.clone(),
                    items: members.start..next.min(members.end),
                });
            }
            if members.start > next {
                absent.push(next..members.start);
            }
            next = members.end;
            last = Some(shard);
        }
        if next < items.end {
            absent.push(next..items.end);
        }
        if absent.is_empty() {
            return Ok(());
        }
        Err(MergeError::Missing(Missing {
            shards: self.numbers_of(&absent),
            items: absent,
            whole: self.whole,
            unfinished: unfinished
                .into_iter()
                .map(|shard| shard.directory.clone())
                .collect(),
        }))
    }

    /// The numbers of the shards that hold these, where all shards were cut alike.
    fn numbers_of(&self, absent: &[Range<u64>]) -> Option<(Vec<[u64; 2]>, u64)> {
        let [_, of] = self.all[0].record.place?;
        if of > MOST_NUMBERED {
            return None;
        }
        let ensemble = self.all[0].record.ensemble;
        let is_alike = |shard: &Found| shard.record.place.is_some_and(|[_, other]| other == of);
        if !self.all.iter().all(is_alike) {
            return None;
        }
        let mut numbers: Vec<[u64; 2]> = Vec::new();
        for number in 1..=of {
            let members = Shard::of(self.whole, number, of, ensemble).ok()?.items();
            let is_absent =
                |range: &Range<u64>| members.start < range.end && range.start < members.end;
            if members.is_empty() || !absent.iter().any(is_absent) {
                continue;
            }
            match numbers.last_mut() {
                Some([_, last]) if *last + 1 == number => *last = number,
                _ => numbers.push([number; 2]),
            }
        }
        Some((numbers, of))
    }
}

/// The folders in a directory, by name.
fn folders(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        if path.is_dir() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Whether two paths lead to one directory.
pub(in crate::job) fn is_same(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => a == b,
    }
}
