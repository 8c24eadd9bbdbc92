//! The JSON of `tabulate`.

use leafwise::learn::{ManySteps, Tabulated};
use serde::Serialize;

use super::cost::{Cost, Steps};

/// The object of `tabulate --json`.
#[derive(Serialize)]
struct TabulateJson {
    outcome: &'static str,
    steps: u64,
    time_step: f64,
    degree: usize,
    functions: usize,
    pairs: usize,
    motion: f64,
    residual: f64,
    /// Root mean square of a coordinate at states that no pair has, and the largest.
    error: f64,
    largest_error: f64,
    unseen: usize,
    failed: usize,
    without_steps: usize,
    determinant: Option<f64>,
    /// Seconds a state over the time step.
    seconds: f64,
    method: StepsJson,
    /// The fewest steps of the method that err no more than the table.
    as_good: StepsJson,
    warnings: Vec<String>,
    /// The scene whose step is the table.
    text: String,
}

#[derive(Serialize)]
struct StepsJson {
    steps: u64,
    error: f64,
    seconds: f64,
}

impl From<Steps> for StepsJson {
    fn from(own: Steps) -> Self {
        Self {
            steps: own.count,
            error: own.error,
            seconds: own.seconds,
        }
    }
}

/// The table as an object.
pub(super) fn json(
    table: &Tabulated,
    steps: &ManySteps<'_>,
    cost: &Cost,
    warnings: &[String],
    text: String,
) -> impl Serialize + use<> {
    TabulateJson {
        outcome: "tabulated",
        steps: steps.count,
        time_step: steps.duration(),
        degree: table.learned.degree,
        functions: table.learned.functions.len(),
        pairs: table.learned.pairs,
        motion: table.learned.motion,
        residual: table.learned.residual,
        error: table.error,
        largest_error: table.largest_error,
        unseen: table.unseen.len(),
        failed: table.failed,
        without_steps: table.without_steps,
        determinant: table.determinant,
        seconds: cost.table,
        method: cost.own.into(),
        as_good: cost.fewest.into(),
        warnings: warnings.to_vec(),
        text,
    }
}
