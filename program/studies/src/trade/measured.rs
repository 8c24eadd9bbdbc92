//! Measurements of a run: its cost, its errors and the invariants and structure that it keeps.

use std::fmt;

use leafwise_core::Structure;
use leafwise_core::diagnostics::Defect;
use leafwise_scene::ComposedRun;
use leafwise_scene::json::{double, optional};
use serde::Serialize;

use super::norm::distance;
use super::reference::Reference;
use super::trial::{Trial, Wall, tensor_defect};

/// Measurements of a run: its cost, its errors and the invariants and structure that it keeps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Operations of the whole run, as
    /// [`SolverStatistics::operations`](leafwise_core::SolverStatistics::operations) counts them.
    pub operations: Option<u64>,
    /// Evaluations of the whole run.
    pub evaluations: u64,
    /// How long it took.
    #[serde(rename = "wall_seconds")]
    pub wall: Option<Wall>,
    /// ‖x − x*‖ where runs are judged: the largest over every step, or at the end time.
    #[serde(serialize_with = "double")]
    pub error: f64,
    /// The same over the largest ‖x*‖ there.
    #[serde(serialize_with = "double")]
    pub relative_error: f64,
    /// ‖x − x*‖ at the end time.
    #[serde(serialize_with = "double")]
    pub end_error: f64,
    /// Whether the error is below ten times the reference's own: it may be smaller or larger.
    pub at_floor: bool,
    /// max |H(x_k) − H(x_0)| over every step.
    #[serde(serialize_with = "double")]
    pub energy_drift: f64,
    /// The largest max |C(x_k) − C(x_0)| of a Casimir over every step; `None` where there is none.
    #[serde(serialize_with = "optional")]
    pub casimir_drift: Option<f64>,
    /// The tensor defect of one step, from the first state and from the last, relative; `None`
    /// where the map offers no tangent.
    #[serde(serialize_with = "optional")]
    pub tensor_defect: Option<f64>,
    /// Whether the run is one of a Poisson map: declared exact and not found otherwise, or declared to some
    /// order and with a tensor defect of round-off at this step.
    #[serde(rename = "poisson")]
    pub is_poisson: bool,
    /// Which fronts it stands on.
    pub front: Front,
}

/// Measure of cost by which runs of several methods are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Counted operations, where any method counts its own.
    Operations,
    /// Wall time, where none does: the system is numbers from elsewhere.
    Time,
    /// Evaluations, where times would be too noisy to search by. One means a step kernel for one
    /// method, all stages for another.
    Evaluations,
}

impl Cost {
    /// The cost of a run; `None` where it was not measured.
    pub fn of(self, measured: &Measured) -> Option<f64> {
        match self {
            Self::Operations => measured.operations.map(|count| count as f64),
            Self::Time => measured.wall.map(|wall| wall.seconds),
            Self::Evaluations => Some(measured.evaluations as f64),
        }
    }

    /// In a word: `operations`, `time`, `evaluations`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Operations => "operations",
            Self::Time => "time",
            Self::Evaluations => "evaluations",
        }
    }
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operations => f.write_str("in counted operations"),
            Self::Time | Self::Evaluations => write!(
                f,
                "in {}: the operations of this system's functions are not known",
                self.word()
            ),
        }
    }
}

/// The fronts on which a point stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Front {
    /// Error against [`Cost`], among all methods.
    pub all: bool,
    /// The same among Poisson maps.
    pub poisson: bool,
    /// Error against wall time, among all methods.
    pub wall: bool,
}

impl Measured {
    /// Evaluates a trial of `run` against the reference; `structure` is the declared one of the method.
    pub(super) fn of(
        trial: &Trial,
        run: &ComposedRun,
        time_step: f64,
        structure: Structure,
        reference: &Reference,
    ) -> Self {
        let error = reference.error_of(trial);
        let size = reference.norm();
        let states: [&[f64]; 2] = [&run.plan.initial, &trial.stepped];
        let tensor_defect = tensor_defect(run, time_step, &states);
        Self {
            operations: trial.statistics.operations,
            evaluations: trial.statistics.evaluations,
            wall: None,
            error,
            relative_error: if size > 0.0 { error / size } else { error },
            end_error: distance(&trial.state, &reference.state),
            at_floor: error <= reference.floor(),
            energy_drift: trial.drift.first().copied().unwrap_or(0.0),
            casimir_drift: trial.drift.iter().skip(1).copied().reduce(f64::max),
            tensor_defect,
            is_poisson: is_poisson(structure, tensor_defect),
            front: Front::default(),
        }
    }

    /// The cost by which runs are compared: counted operations, or evaluations where a part does
    /// not count its own.
    pub fn cost(&self) -> u64 {
        self.operations.unwrap_or(self.evaluations)
    }
}

/// A tensor defect beyond this belies a map that is declared exact: half of the digits are more than an
/// ill-conditioned solve loses.
const BELIED: f64 = 1e-8;

/// Whether a map of this declared structure and measured defect is Poisson to round-off.
pub(super) fn is_poisson(structure: Structure, tensor_defect: Option<f64>) -> bool {
    match structure {
        Structure::Exact => tensor_defect.is_none_or(|defect| defect <= BELIED),
        Structure::Order(_) => tensor_defect.is_some_and(|defect| defect <= Defect::ROUND_OFF),
        Structure::Leaves | Structure::Contact | Structure::None => false,
    }
}
