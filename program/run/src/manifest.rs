//! Manifest of a run, `manifest.json`: what was run, with what, and how it ended.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use leafwise_core::diagnostics::Verdict;
use leafwise_core::{Origin, PartKind, SolverStatistics, StepMap};
use leafwise_expression::OperationCount;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

use super::advice::Advice;
use super::error::RunError;
use super::outcome::{Failure, InvariantDrift, RunReport};
use super::replaced::replace;
use super::time::now;
use super::{samples, states};
use leafwise_scene::compose::{ComposedRun, PartChoice, RecordedStates, SceneChecks, StateSlice};
use leafwise_scene::document::SceneDocument;
use leafwise_scene::json::{Double, object, pretty};

/// The version that is written into manifests and reports.
pub const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Name of the program in a manifest.
const PROGRAM: &str = "leafwise";

/// The file's name in the run directory, and before it has it.
pub(super) const FILE: &str = "manifest.json";
pub(super) const UNFINISHED_FILE: &str = "manifest.new";

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
    pub(super) fn words(self) -> &'static str {
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

/// Beginning of a manifest: all that it says before the first step.
#[derive(Clone, Serialize)]
pub(crate) struct Beginning<'a> {
    program: &'static str,
    kind: Kind,
    version: &'static str,
    command: &'a str,
    scene: &'a str,
    library: Option<&'a str>,
    dimension: usize,
    variables: Variables<'a>,
    #[serde(serialize_with = "object")]
    parameters: Vec<(&'a str, Double)>,
    initial: Option<Vec<Double>>,
    states: Option<StatesFields<'a>>,
    tensor: String,
    checks: Checks<'a>,
    system: Option<Part<'a>>,
    parts: Vec<Part<'a>>,
    plugins: Vec<PluginRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    files: Option<FilesRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shard: Option<ShardRecord>,
    path: String,
    declared_order: usize,
    epsilon: f64,
    h: f64,
    kernels: Kernels,
    started: String,
}

/// A manifest as it is written: the beginning, the time of the end and what is told of it.
#[derive(Serialize)]
struct Written<'a, E> {
    #[serde(flatten)]
    beginning: &'a Beginning<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ended: Option<String>,
    #[serde(flatten)]
    ending: E,
}

/// End of the manifest of a run of one trajectory.
#[derive(Serialize)]
struct Ending<'a> {
    outcome: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped_by: Option<&'a str>,
    steps: u64,
    time: Double,
    wall_seconds: f64,
    samples: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    crossings: Option<u64>,
    #[serde(with = "WorkFields")]
    solver: SolverStatistics,
    #[serde(serialize_with = "object")]
    drift: Vec<(&'a str, Double)>,
    #[serde(serialize_with = "object")]
    invariants: Vec<(&'a str, &'a InvariantDrift)>,
    machine_code: Vec<MachineCode>,
    warnings: &'a [Advice],
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<&'a Failure>,
}

/// The solver's work.
#[derive(Serialize)]
#[serde(remote = "SolverStatistics")]
struct WorkFields {
    evaluations: u64,
    #[serde(getter = "SolverStatistics::evaluations_per_step")]
    evaluations_per_step: f64,
    most_evaluations: u64,
    failures: u64,
    rounded: u64,
    held: f64,
}

/// The coordinates' names, or the families with their lengths where there are too many.
#[derive(Clone, Serialize)]
#[serde(untagged)]
enum Variables<'a> {
    Names(Vec<String>),
    #[serde(serialize_with = "object")]
    Families(&'a [(String, usize)]),
}

/// Where the recorded states are: the file, its columns or the slices they come from, and its shape.
#[derive(Clone, Serialize)]
struct StatesFields<'a> {
    file: Option<&'static str>,
    /// Samples and columns.
    shape: (u64, usize),
    columns: Option<Vec<String>>,
    slices: &'a [StateSlice],
    last: Option<&'static str>,
}

/// Checks of the scene's formulas: verdicts on the Jacobi identity and on each Casimir.
#[derive(Clone, Serialize)]
struct Checks<'a> {
    jacobi: Verdict,
    #[serde(serialize_with = "object")]
    casimirs: Vec<(&'a str, Verdict)>,
}

/// A part as chosen; a composition has no values of its own.
#[derive(Clone, Serialize)]
struct Part<'a> {
    #[serde(flatten)]
    choice: &'a PartChoice,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<&'static str>,
}

/// Computations of a step: the kernels' operations, or the costs that a map has of its own.
#[derive(Clone, Serialize)]
#[serde(untagged)]
enum Kernels {
    Newton {
        #[serde(with = "OperationFields")]
        newton_iteration: OperationCount,
        #[serde(with = "OperationFields")]
        residual: OperationCount,
        #[serde(with = "OperationFields")]
        coefficients: OperationCount,
    },
    #[serde(serialize_with = "object")]
    Costs(Vec<(&'static str, String)>),
}

/// The operations of a kernel.
#[derive(Serialize)]
#[serde(remote = "OperationCount")]
struct OperationFields {
    #[serde(getter = "OperationCount::total")]
    total: usize,
    additions: usize,
    multiplications: usize,
    divisions: usize,
    negations: usize,
    functions: usize,
}

/// A kernel of the steps that was compiled to machine code, for a number of lanes.
#[derive(Serialize)]
struct MachineCode {
    kernel: &'static str,
    operations: usize,
    lanes: usize,
    bytes: usize,
}

impl<'a> Beginning<'a> {
    /// Describes a run begun at `started`, or now.
    pub fn new(
        kind: Kind,
        document: &'a SceneDocument,
        run: &'a ComposedRun,
        checks: &'a SceneChecks,
        command: &'a str,
        started: Option<String>,
    ) -> Self {
        let casimirs = checks.casimirs.iter();
        let parameters = run.system.parameters().iter();
        let own = run.own(&run.plan.initial);
        let is_short = own.len() <= MOST_WRITTEN;
        let initial = own.iter().copied().map(Double);
        Self {
            program: PROGRAM,
            kind,
            version: PROGRAM_VERSION,
            command,
            scene: &document.name,
            library: document.fragment.as_ref().map(|(id, _)| id.as_str()),
            dimension: own.len(),
            variables: match is_short {
                true => Variables::Names(run.names()),
                false => Variables::Families(&run.plan.families),
            },
            parameters: parameters
                .map(|parameter| (parameter.name.as_str(), Double(parameter.value)))
                .collect(),
            initial: is_short.then(|| initial.collect()),
            states: (kind == Kind::Run).then(|| StatesFields::of(&run.plan.states)),
            tensor: run.tensor_shape().to_string(),
            checks: Checks {
                jacobi: checks.jacobi.verdict,
                casimirs: casimirs
                    .map(|casimir| (casimir.name.as_str(), casimir.check.verdict))
                    .collect(),
            },
            system: run.plan.system.as_ref().map(|choice| Part::of(choice, run)),
            parts: run
                .plan
                .parts
                .iter()
                .map(|choice| Part::of(choice, run))
                .collect(),
            plugins: plugins(run),
            files: files(run),
            shard: None,
            path: run.path(),
            declared_order: run.method.declared_order(),
            epsilon: run.plan.epsilon,
            h: run.plan.h,
            kernels: Kernels::of(run),
            started: started.unwrap_or_else(now),
        }
    }

    /// The same of some members of an ensemble.
    pub fn of_shard(self, shard: Option<ShardRecord>) -> Self {
        Self { shard, ..self }
    }

    /// The same of a run that has read these files.
    pub fn of_files(self, files: Option<FilesRecord>) -> Self {
        Self { files, ..self }
    }

    /// Writes the manifest of a run that goes on.
    pub fn write_running(&self, directory: &Path) -> Result<(), RunError> {
        self.write(directory, None, BTreeMap::from([("outcome", "running")]))
    }

    /// Writes the manifest of a run that has ended, with what its kind tells of the end.
    pub fn write_end(&self, directory: &Path, ending: impl Serialize) -> Result<(), RunError> {
        self.write(directory, Some(now()), ending)
    }

    /// Writes the manifest of a run of one trajectory that has ended.
    pub fn write_ended(
        &self,
        directory: &Path,
        report: &RunReport,
        map: &dyn StepMap,
    ) -> Result<(), RunError> {
        let mut beginning = self.clone();
        if let Some(states) = &mut beginning.states {
            states.shape.0 = report.samples;
        }
        let ending = Ending {
            outcome: report.outcome.word(),
            stopped_by: report.outcome.stopped_by(),
            steps: report.steps,
            time: Double(report.time),
            wall_seconds: report.wall_seconds,
            samples: report.samples,
            crossings: report.crossings,
            solver: report.statistics,
            drift: report.drift(),
            invariants: report.named_invariants(),
            machine_code: machine_code(map),
            warnings: &report.advice,
            failure: report.outcome.failure(),
        };
        beginning.write_end(directory, ending)
    }

    fn write(
        &self,
        directory: &Path,
        ended: Option<String>,
        ending: impl Serialize,
    ) -> Result<(), RunError> {
        let file = directory.join(FILE);
        let written = Written {
            beginning: self,
            ended,
            ending,
        };
        let text = pretty(&written).map_err(RunError::io(&file))?;
        replace(&file, format!("{text}\n").as_bytes())
    }
}

/// Names, or numbers of a state, that a manifest writes out at most.
const MOST_WRITTEN: usize = 1024;

impl<'a> StatesFields<'a> {
    fn of(recorded: &'a RecordedStates) -> Self {
        let width = recorded.width();
        Self {
            file: match recorded.are_in_samples() {
                _ if width == 0 => None,
                true => Some(samples::FILE),
                false => Some(states::FILE),
            },
            shape: (0, width),
            columns: (width <= MOST_WRITTEN).then(|| recorded.names()),
            slices: &recorded.slices,
            last: (!recorded.is_whole_in_samples()).then_some(states::FINAL_STATE),
        }
    }
}

impl<'a> Part<'a> {
    fn of(choice: &'a PartChoice, run: &ComposedRun) -> Self {
        let has_values = choice.kind != PartKind::Composition;
        let path = has_values.then(|| run.path_of(choice));
        Self { choice, path }
    }
}

impl Kernels {
    fn of(run: &ComposedRun) -> Self {
        match run.method.written().and_then(|method| method.newton()) {
            Some(newton) => Self::Newton {
                newton_iteration: newton.operations(),
                residual: newton.residual_operations(),
                coefficients: newton.coefficient_operations(),
            },
            None => Self::Costs(run.method.costs()),
        }
    }
}

/// Record of the files that a run read; `None` where its scene names none.
pub(crate) fn files(run: &ComposedRun) -> Option<FilesRecord> {
    let paths = run.plan.files.clone();
    (!paths.is_empty()).then(|| FilesRecord {
        paths,
        sha256: digest(&run.plan.initial)
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect(),
    })
}

/// SHA-256 of the doubles' bytes.
pub(crate) fn digest(values: &[f64]) -> [u8; 32] {
    let mut digest = Sha256::new();
    for value in values {
        digest.update(value.to_le_bytes());
    }
    digest.finalize().into()
}

/// The libraries that parts come from, each once.
pub(crate) fn plugins(run: &ComposedRun) -> Vec<PluginRecord> {
    let mut plugins: Vec<PluginRecord> = Vec::new();
    for choice in run.plan.parts.iter().chain(&run.plan.system) {
        let Some(Origin::Library {
            path,
            sha256,
            version,
            abi,
        }) = &choice.origin
        else {
            continue;
        };
        let place = plugins.iter().position(|known| known.path == *path);
        let place = place.unwrap_or_else(|| {
            plugins.push(PluginRecord {
                path: path.clone(),
                sha256: sha256.clone(),
                version: version.clone(),
                abi: abi.clone(),
                parts: Map::new(),
            });
            plugins.len() - 1
        });
        let parts = &mut plugins[place].parts;
        parts.insert(choice.name.to_owned(), choice.path.into());
    }
    plugins
}

/// The kernels of the steps that were compiled to machine code, for each number of lanes.
fn machine_code(map: &dyn StepMap) -> Vec<MachineCode> {
    let mut compiled = Vec::new();
    for (kernel, code) in map.kernels() {
        for size in code.machine_code() {
            compiled.push(MachineCode {
                kernel,
                operations: code.step_operations().total(),
                lanes: size.lanes,
                bytes: size.bytes,
            });
        }
    }
    compiled
}
