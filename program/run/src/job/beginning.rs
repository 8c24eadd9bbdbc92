//! Manifest of a job as it is written: all that is told before its first step, and how it ended.

use std::collections::BTreeMap;
use std::path::Path;

use leafwise_core::diagnostics::Verdict;
use leafwise_core::{Origin, PartKind};
use leafwise_expression::OperationCount;
use serde::Serialize;
use serde_json::Map;
use sha2::{Digest, Sha256};

use super::manifest::{
    FILE, FilesRecord, Kind, PROGRAM, PROGRAM_VERSION, PluginRecord, ShardRecord, hexadecimal,
};
use super::subject::JobSubject;
use super::time::now;
use crate::{RunError, replace, samples, states};
use leafwise_scene::compose::{ComposedRun, PartChoice, RecordedStates, RunPlan, StateSlice};
use leafwise_scene::json::{Double, object, pretty};

/// Beginning of a manifest: all that it says before the first step.
#[derive(Serialize)]
pub struct Beginning<'a> {
    program: &'static str,
    kind: Kind,
    version: &'static str,
    command: &'a str,
    scene: &'a str,
    library: Option<&'a str>,
    dimension: usize,
    variables: Variables<'a>,
    /// The number of sites along each axis of the families.
    axes: Vec<usize>,
    /// The names of the sites of a chain, where they have any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    site_names: Vec<&'a str>,
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

/// The coordinates' names, or the families with their lengths where there are too many.
#[derive(Serialize)]
#[serde(untagged)]
enum Variables<'a> {
    Names(Vec<String>),
    #[serde(serialize_with = "object")]
    Families(&'a [(String, usize)]),
}

/// Where the recorded states are: the file, its columns or the slices they come from, and its shape.
#[derive(Serialize)]
struct StatesFields<'a> {
    file: Option<&'static str>,
    /// Samples and columns.
    shape: (u64, usize),
    columns: Option<Vec<String>>,
    slices: &'a [StateSlice],
    last: Option<&'static str>,
}

/// Checks of the scene's formulas: verdicts on the Jacobi identity and on each Casimir.
#[derive(Serialize)]
struct Checks<'a> {
    jacobi: Verdict,
    #[serde(serialize_with = "object")]
    casimirs: Vec<(&'a str, Verdict)>,
}

/// A part as chosen; a composition has no values of its own.
#[derive(Serialize)]
struct Part<'a> {
    #[serde(flatten)]
    choice: &'a PartChoice,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<&'static str>,
}

/// Computations of a step: the kernels' operations, or the costs that a map has of its own.
#[derive(Serialize)]
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

impl<'a> Beginning<'a> {
    /// Describes a job begun at `started`, or now.
    pub fn new(subject: &JobSubject<'a>, started: Option<String>) -> Self {
        let JobSubject {
            document,
            run,
            checks,
            ..
        } = *subject;
        let casimirs = checks.casimirs.iter();
        let parameters = run.system.parameters().iter();
        let own = run.own(&run.plan.initial);
        let is_short = own.len() <= MOST_WRITTEN;
        let initial = own.iter().copied().map(Double);
        Self {
            program: PROGRAM,
            kind: subject.kind,
            version: PROGRAM_VERSION,
            command: &subject.options.command,
            scene: &document.name,
            library: document.fragment.as_ref().map(|(id, _)| id.as_str()),
            dimension: own.len(),
            variables: match is_short {
                true => Variables::Names(run.names()),
                false => Variables::Families(&run.plan.families),
            },
            axes: match run.plan.families.is_empty() {
                true => Vec::new(),
                false => run.plan.sites.geometry.lengths(),
            },
            site_names: run.plan.sites.geometry.site_names.iter().collect(),
            parameters: parameters
                .map(|parameter| (parameter.name.as_str(), Double(parameter.value)))
                .collect(),
            initial: is_short.then(|| initial.collect()),
            states: (subject.kind == Kind::Run).then(|| StatesFields::of(&run.plan.states)),
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
            files: subject.files.clone(),
            shard: subject.shard,
            path: run.path(),
            declared_order: run.method.declared_order(),
            epsilon: run.plan.epsilon,
            h: run.plan.h,
            kernels: Kernels::of(run),
            started: started.unwrap_or_else(now),
        }
    }

    /// The same of a run that has recorded so many samples.
    pub fn of_samples(mut self, samples: u64) -> Self {
        if let Some(states) = &mut self.states {
            states.shape.0 = samples;
        }
        self
    }

    /// Writes the manifest of a job that goes on.
    pub fn write_running(&self, directory: &Path) -> Result<(), RunError> {
        self.write(directory, None, BTreeMap::from([("outcome", "running")]))
    }

    /// Writes the manifest of a job that has ended, with what its kind tells of the end.
    pub fn write_end(&self, directory: &Path, ending: impl Serialize) -> Result<(), RunError> {
        self.write(directory, Some(now()), ending)
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
        sha256: hexadecimal(&digest(&run.plan)),
    })
}

/// SHA-256 of the bytes of all doubles that files give: the initial state, then the coefficients of tables, then matrices.
fn digest(plan: &RunPlan) -> [u8; 32] {
    let mut digest = Sha256::new();
    let tables = plan.tables.iter().map(|table| table.coefficients());
    let matrices = plan.matrices.iter().map(|numbers| &numbers[..]);
    let all = std::iter::once(&plan.initial[..]).chain(tables);
    for value in all.chain(matrices).flatten() {
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
