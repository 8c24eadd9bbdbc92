//! End of the manifest of a run of one trajectory.

use leafwise_core::{SolverStatistics, StepMap};
use serde::Serialize;

use super::advice::Advice;
use super::invariants::InvariantDrift;
use super::outcome::{Failure, RunReport};
use leafwise_scene::json::{Double, object};

/// End of the manifest of a run of one trajectory.
#[derive(Serialize)]
pub(super) struct RunEnding<'a> {
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

/// A kernel of the steps that was compiled to machine code, for a number of lanes.
#[derive(Serialize)]
struct MachineCode {
    kernel: &'static str,
    operations: usize,
    lanes: usize,
    bytes: usize,
}

impl<'a> RunEnding<'a> {
    /// Describes a run by this map that has ended.
    pub fn new(report: &'a RunReport, map: &dyn StepMap) -> Self {
        Self {
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
        }
    }
}

/// The kernels of the steps that were compiled to machine code, for each number of lanes.
fn machine_code(map: &dyn StepMap) -> Vec<MachineCode> {
    let mut compiled = Vec::new();
    for (kernel, code) in map.abilities().kernels {
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
