//! Manifest of a job, `manifest.json`, as it is read: whose a directory is, and whether its job can go on.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::{RunError, replace};

/// The version that is written into manifests and reports.
pub const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Name of the program in a manifest.
pub(super) const PROGRAM: &str = "leafwise";

/// The file's name in the run directory, and before it has it.
pub(crate) const FILE: &str = "manifest.json";
pub(super) const UNFINISHED_FILE: &str = "manifest.new";

/// Everything later steps depend on.
pub(crate) const CHECKPOINT: &str = "checkpoint.bin";
/// The scene as run.
pub(crate) const SCENE: &str = "scene.toml";
/// The page to open.
pub(crate) const REPORT: &str = "report.html";

/// Kind of run that a directory holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One trajectory.
    #[default]
    Run,
    /// Many.
    Ensemble,
    /// Some of those many.
    Shard,
    /// One trajectory for each of many settings.
    Sweep,
    /// Some of those settings.
    SweepShard,
}

impl Kind {
    /// For messages.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Run => "a run of one trajectory",
            Self::Ensemble => "an ensemble",
            Self::Shard => "a shard of an ensemble",
            Self::Sweep => "a sweep",
            Self::SweepShard => "a shard of a sweep",
        }
    }
}

/// Fields of a stored manifest that decide whether a run is resumed.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Manifest {
    /// `leafwise`.
    pub program: String,
    /// The version of the program that began the run.
    pub version: String,
    /// `running`, `done`, `stopped`, `interrupted` or `failed`.
    pub outcome: String,
    /// When the run was begun.
    pub started: String,
    /// One trajectory or many.
    #[serde(default)]
    pub kind: Kind,
    /// The libraries it uses.
    #[serde(default)]
    pub plugins: Vec<PluginRecord>,
    /// Record of the files that it read.
    #[serde(default)]
    pub files: Option<FilesRecord>,
    /// The scene file's name.
    #[serde(default)]
    pub scene: String,
    /// How its steps are computed.
    #[serde(default)]
    pub path: String,
    /// Which members of an ensemble.
    #[serde(default)]
    pub shard: Option<ShardRecord>,
}

/// Members of an ensemble or settings of a sweep, for a shard's directory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardRecord {
    /// The first of them and the one behind the last.
    pub members: [u64; 2],
    /// How many there are in the whole.
    pub ensemble: u64,
    /// Which of how many shards it is, counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[u64; 2]>,
}

/// Values of sites that a run read from files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilesRecord {
    /// The files, as the scene names them.
    pub paths: Vec<String>,
    /// SHA-256 of the state that the run begins with and of its parameters of sites, in hexadecimal.
    pub sha256: String,
}

/// A library that a run uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PluginRecord {
    /// The file.
    pub path: PathBuf,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// The version it states.
    pub version: String,
    /// The plugin interface it was built for.
    pub abi: String,
    /// The parts taken from it, each with where its values come from.
    pub parts: Map<String, Value>,
}

/// Bytes as hexadecimal digits.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Makes the manifest of a directory say that its job is unfinished; all else in it stays.
pub(super) fn unfinish(directory: &Path) -> Result<(), RunError> {
    let file = directory.join(FILE);
    let text = fs::read_to_string(&file).map_err(RunError::reading(&file))?;
    let Ok(mut manifest) = serde_json::from_str::<Map<String, Value>>(&text) else {
        return Ok(());
    };
    manifest.insert("outcome".to_owned(), "running".into());
    let text = format!("{:#}\n", Value::from(manifest));
    replace(&file, text.as_bytes())
}

impl Manifest {
    /// The manifest of a directory; `None` when there is none of this program that can be read.
    pub fn read(directory: &Path) -> Option<Self> {
        let text = fs::read_to_string(directory.join(FILE)).ok()?;
        let manifest: Self = serde_json::from_str(&text).ok()?;
        (manifest.program == PROGRAM).then_some(manifest)
    }

    /// Whether the run can go on.
    pub fn is_unfinished(&self) -> bool {
        self.outcome == "running" || self.outcome == "interrupted"
    }
}
