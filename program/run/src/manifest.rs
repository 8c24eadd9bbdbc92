//! What was run, with what, and how it ended: `manifest.json`.

use std::fs;
use std::path::{Path, PathBuf};

use leafwise_core::diagnostics::Verdict;
use leafwise_core::{Origin, PartKind, StepMap};
use leafwise_expression::OperationCount;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::error::RunError;
use super::outcome::{RunOutcome, RunReport};
use super::replaced::replace;
use super::time::now;
use super::{samples, states};
use crate::json::{json_number, json_numbers};
use leafwise_scene::compose::{
    ComposedRun, PartChoice, SceneChecks, StateSlice, TensorShape, tensor_shape,
};
use leafwise_scene::document::SceneDocument;

/// The version that is written into manifests and reports.
pub const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a manifest says of the program.
const PROGRAM: &str = "leafwise";

/// The file's name in the run directory, and before it has it.
pub(super) const FILE: &str = "manifest.json";
pub(super) const UNFINISHED_FILE: &str = "manifest.new";

/// What a directory holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// One trajectory.
    #[default]
    Run,
    /// Many.
    Ensemble,
}

impl Kind {
    /// For messages.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Run => "a run of one trajectory",
            Self::Ensemble => "an ensemble",
        }
    }
}

/// What of a stored manifest decides whether a run is resumed.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Manifest {
    /// `leafwise`.
    pub program: String,
    /// The version of the program that began the run.
    pub version: String,
    /// `running`, `done`, `interrupted` or `failed`.
    pub outcome: String,
    /// When the run was begun.
    pub started: String,
    /// One trajectory or many.
    #[serde(default)]
    pub kind: Kind,
    /// The libraries it uses.
    #[serde(default)]
    pub plugins: Vec<PluginRecord>,
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

/// The word for an outcome.
pub(crate) fn outcome_word(outcome: &RunOutcome) -> &'static str {
    match outcome {
        RunOutcome::Done => "done",
        RunOutcome::Interrupted => "interrupted",
        RunOutcome::Failed(_) => "failed",
    }
}

/// What a manifest says before the first step.
pub(crate) struct Beginning {
    fields: Map<String, Value>,
}

impl Beginning {
    /// Describes a run begun at `started`, or now.
    pub fn new(
        kind: Kind,
        document: &SceneDocument,
        run: &ComposedRun,
        checks: &SceneChecks,
        command: &str,
        started: Option<String>,
    ) -> Self {
        let parts: Vec<Value> = run.plan.parts.iter().map(|c| part(c, run)).collect();
        let casimirs: Map<String, Value> = checks
            .casimirs
            .iter()
            .map(|casimir| {
                (
                    casimir.name.clone(),
                    json!(verdict_word(casimir.check.verdict)),
                )
            })
            .collect();
        let kernels = match run.method.written().and_then(|method| method.newton()) {
            Some(newton) => json!({
                "newton_iteration": operations(newton.operations()),
                "residual": operations(newton.residual_operations()),
                "coefficients": operations(newton.coefficient_operations()),
            }),
            None => run
                .method
                .costs()
                .into_iter()
                .map(|(label, cost)| (label.to_owned(), json!(cost)))
                .collect::<Map<String, Value>>()
                .into(),
        };
        let shape: TensorShape = tensor_shape(&run.system);
        let fields = json!({
            "program": PROGRAM,
            "kind": kind,
            "version": PROGRAM_VERSION,
            "command": command,
            "scene": document.name,
            "library": document.fragment.as_ref().map(|(id, _)| id),
            "dimension": run.dimension(),
            "variables": variables(run),
            "parameters": parameters(run),
            "initial": (run.dimension() <= MOST_WRITTEN).then(|| json_numbers(&run.plan.initial)),
            "states": (kind == Kind::Run).then(|| recorded_states(run)),
            "tensor": shape.to_string(),
            "checks": { "jacobi": verdict_word(checks.jacobi.verdict), "casimirs": casimirs },
            "system": run.plan.system.as_ref().map(|c| part(c, run)),
            "parts": parts,
            "plugins": plugins(run),
            "path": run.path(),
            "declared_order": run.method.declared_order(),
            "epsilon": run.plan.epsilon,
            "h": run.plan.h,
            "kernels": kernels,
            "started": started.unwrap_or_else(now),
        });
        match fields {
            Value::Object(fields) => Self { fields },
            _ => Self { fields: Map::new() },
        }
    }

    /// Writes the manifest of a run that goes on.
    pub fn write_running(&self, directory: &Path) -> Result<(), RunError> {
        let mut fields = self.fields.clone();
        fields.insert("outcome".to_owned(), json!("running"));
        write(directory, fields)
    }

    /// Writes the manifest of a run that has ended, with what its kind tells of the end.
    pub fn write_end(&self, directory: &Path, ending: Value) -> Result<(), RunError> {
        let mut fields = self.fields.clone();
        if let Value::Object(ending) = ending {
            fields.insert("ended".to_owned(), json!(now()));
            fields.extend(ending);
        }
        write(directory, fields)
    }

    /// Writes the manifest of a run of one trajectory that has ended.
    pub fn write_ended(&self, report: &RunReport, map: &dyn StepMap) -> Result<(), RunError> {
        let mut ending = json!({
            "outcome": outcome_word(&report.outcome),
            "steps": report.steps,
            "time": json_number(report.time),
            "wall_seconds": report.wall_seconds,
            "samples": report.samples,
            "solver": {
                "evaluations": report.statistics.evaluations,
                "evaluations_per_step": report.statistics.evaluations_per_step(),
                "most_evaluations": report.statistics.most_evaluations,
                "failures": report.statistics.failures,
                "rounded": report.statistics.rounded,
            },
            "drift": report.drift_json(),
            "invariants": report.invariants_json(),
            "machine_code": machine_code(map),
            "warnings": report.advice,
        });
        if let Some(Value::Object(states)) = self.fields.get("states") {
            let mut states = states.clone();
            let width = states["shape"][1].clone();
            states["shape"] = json!([report.samples, width]);
            ending["states"] = Value::Object(states);
        }
        if let RunOutcome::Failed(failure) = &report.outcome {
            ending["failure"] = json!({
                "message": failure.message, "step": failure.step,
                "time": json_number(failure.time), "state": json_numbers(&failure.state),
                "hint": failure.hint,
            });
        }
        self.write_end(&report.directory, ending)
    }
}

/// Names, or numbers of a state, that a manifest writes out at most.
const MOST_WRITTEN: usize = 1024;

/// The coordinates' names, or the families with their lengths where there are too many.
fn variables(run: &ComposedRun) -> Value {
    if run.dimension() <= MOST_WRITTEN {
        return json!(run.names());
    }
    let families = run.plan.families.iter();
    families
        .map(|(name, length)| (name.clone(), json!(length)))
        .collect::<Map<String, Value>>()
        .into()
}

fn parameters(run: &ComposedRun) -> Value {
    let parameters = run.system.parameters().iter();
    parameters
        .map(|parameter| (parameter.name.clone(), json_number(parameter.value)))
        .collect::<Map<String, Value>>()
        .into()
}

/// Where the recorded states are: the file, its columns or the slices they come from, and its shape.
fn recorded_states(run: &ComposedRun) -> Value {
    let recorded = &run.plan.states;
    let width = recorded.width();
    let file = match recorded.are_in_samples() {
        _ if width == 0 => None,
        true => Some(samples::FILE),
        false => Some(states::FILE),
    };
    let slice = |slice: &StateSlice| {
        json!({
            "name": slice.name, "first": slice.first, "step": slice.step, "count": slice.count,
        })
    };
    let slices: Vec<Value> = recorded.slices.iter().map(slice).collect();
    json!({
        "file": file,
        "shape": [0, width],
        "columns": (width <= MOST_WRITTEN).then(|| recorded.names()),
        "slices": slices,
        "last": (!recorded.is_whole_in_samples()).then_some(states::FINAL_STATE),
    })
}

/// A part as chosen.
fn part(choice: &PartChoice, run: &ComposedRun) -> Value {
    let parameters: Map<String, Value> = choice
        .parameters
        .iter()
        .map(|(name, v)| ((*name).to_owned(), json!(v)))
        .collect();
    let mut part = json!({
        "kind": choice.kind, "name": choice.name, "parameters": parameters,
        "origin": choice.origin,
        "chosen": if choice.is_automatic { "automatically" } else { "by the scene" },
    });
    if choice.kind != PartKind::Composition {
        part["path"] = json!(run.path_of(choice));
    }
    part
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
        let taken = json!(choice.path);
        plugins[place].parts.insert(choice.name.to_owned(), taken);
    }
    plugins
}

fn write(directory: &Path, fields: Map<String, Value>) -> Result<(), RunError> {
    let text = format!("{:#}\n", Value::Object(fields));
    replace(&directory.join(FILE), text.as_bytes())
}

/// The kernels of the steps that were compiled to machine code, for each number of lanes.
fn machine_code(map: &dyn StepMap) -> Vec<Value> {
    let mut compiled = Vec::new();
    for (name, kernel) in map.kernels() {
        for size in kernel.machine_code() {
            compiled.push(json!({
                "kernel": name, "operations": kernel.step_operations().total(),
                "lanes": size.lanes, "bytes": size.bytes,
            }));
        }
    }
    compiled
}

fn operations(count: OperationCount) -> Value {
    json!({
        "total": count.total(), "additions": count.additions,
        "multiplications": count.multiplications, "divisions": count.divisions,
        "negations": count.negations, "functions": count.functions,
    })
}

/// The word for a verdict.
fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Proved => "proved",
        Verdict::NumericallyZero => "numerically zero",
        Verdict::Violated => "violated",
        _ => "undecided",
    }
}
