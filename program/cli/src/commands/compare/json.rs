//! The object of `compare --json`.

use leafwise::scene::SceneDocument;
use leafwise::scene::json::{Double, doubles};
use leafwise::trade::{ComparedMethod, Comparison, Horizon, Measured, Point, Reference};
use serde::Serialize;

/// Everything that was measured.
#[derive(Serialize)]
pub(super) struct ComparisonJson<'a> {
    outcome: &'static str,
    scene: &'a str,
    time: Double,
    reference: ReferenceFields<'a>,
    horizon: Option<HorizonFields<'a>>,
    budget: u64,
    fronts_by: &'static str,
    methods: &'a [ComparedMethod],
    points: Vec<PointFields<'a>>,
    refused: Vec<Refused<'a>>,
}

/// The reference solution.
#[derive(Serialize)]
pub(in crate::commands) struct ReferenceFields<'a> {
    #[serde(serialize_with = "doubles")]
    state: &'a [f64],
    error: Double,
    floor: Double,
    errors: &'static str,
    methods: &'a [String],
}

/// How long the motion can be known, and why no longer.
#[derive(Serialize)]
pub(in crate::commands) struct HorizonFields<'a> {
    #[serde(flatten)]
    horizon: &'a Horizon,
    message: String,
}

/// A method at one setting.
#[derive(Serialize)]
struct PointFields<'a> {
    method: &'a str,
    steps: u64,
    time_step: Double,
    tolerance: Option<Double>,
    #[serde(flatten)]
    outcome: Outcome<'a>,
}

/// Result at one setting: measured values, or the reason why nothing was measured.
#[derive(Serialize)]
#[serde(untagged)]
enum Outcome<'a> {
    Measured(&'a Measured),
    Failed { failure: String, over_budget: bool },
}

/// A method that does not fit.
#[derive(Serialize)]
struct Refused<'a> {
    method: &'a str,
    reason: &'a str,
}

impl<'a> ComparisonJson<'a> {
    pub(super) fn of(document: &'a SceneDocument, comparison: &'a Comparison) -> Self {
        let refused = |(method, reason): &'a (String, String)| Refused { method, reason };
        let points = comparison.points.iter();
        Self {
            outcome: "done",
            scene: &document.name,
            time: Double(comparison.time),
            reference: (&comparison.reference).into(),
            horizon: comparison.horizon.as_ref().map(HorizonFields::from),
            budget: comparison.budget,
            fronts_by: comparison.cost.word(),
            methods: &comparison.methods,
            points: points
                .map(|point| PointFields::of(comparison, point))
                .collect(),
            refused: comparison.refused.iter().map(refused).collect(),
        }
    }
}

impl<'a> From<&'a Reference> for ReferenceFields<'a> {
    fn from(reference: &'a Reference) -> Self {
        Self {
            state: &reference.state,
            error: Double(reference.error),
            floor: Double(reference.floor()),
            errors: reference.judged().words(),
            methods: &reference.methods,
        }
    }
}

impl<'a> From<&'a Horizon> for HorizonFields<'a> {
    fn from(horizon: &'a Horizon) -> Self {
        Self {
            horizon,
            message: horizon.to_string(),
        }
    }
}

impl<'a> PointFields<'a> {
    fn of(comparison: &'a Comparison, point: &'a Point) -> Self {
        Self {
            method: &comparison.methods[point.method].name,
            steps: point.setting.steps,
            time_step: Double(point.time_step),
            tolerance: point.setting.tolerance.map(Double),
            outcome: match &point.outcome {
                Ok(measured) => Outcome::Measured(measured),
                Err(failure) => Outcome::Failed {
                    failure: failure.to_string(),
                    over_budget: failure.is_over_budget(),
                },
            },
        }
    }
}
