//! The object of `tune --json`.

use leafwise::scene::json::{Double, object};
use leafwise::trade::{Limit, Measured, Reached, Recommendation, RunnerUp, Setting};
use serde::Serialize;

use super::Found;
use super::text::advice;
use crate::commands::compare::json::{HorizonFields, ReferenceFields};

/// Everything that was found.
#[derive(Serialize)]
pub(super) struct TuningJson<'a> {
    outcome: &'static str,
    scene: &'a str,
    time: Double,
    asked: Asked,
    reference: ReferenceFields<'a>,
    recommended: Option<Recommended<'a>>,
    cheapest_of_all: Option<Recommended<'a>>,
    runners_up: Vec<Runner<'a>>,
    limit: Option<Limit>,
    advice: Option<&'static str>,
    horizon: Option<HorizonFields<'a>>,
    nearest: Option<Nearest<'a>>,
    complete: bool,
    unbuilt: usize,
    methods: usize,
    runs: u64,
    costs_in: &'static str,
    spent: u64,
    written: bool,
    written_run: Option<WrittenRun>,
}

/// Request: the largest errors of state, energy and Casimirs, how they are judged, and whether the method is to be a
/// Poisson map.
#[derive(Serialize)]
struct Asked {
    error: Option<Double>,
    errors: &'static str,
    energy: Option<Double>,
    casimir: Option<Double>,
    relative: bool,
    poisson: bool,
}

/// A method with its step.
#[derive(Serialize)]
struct Recommended<'a> {
    name: &'a str,
    method: String,
    steps: u64,
    time_step: Double,
    tolerance: Option<Double>,
    predicted: Option<Predicted>,
    measured: &'a Measured,
}

/// Prediction for a run: its error, and its cost under the name of its unit.
#[derive(Serialize)]
struct Predicted {
    error: Double,
    #[serde(flatten, serialize_with = "object")]
    cost: [(&'static str, Double); 1],
}

/// A method that holds what is asked and is not the cheapest.
#[derive(Serialize)]
struct Runner<'a> {
    name: &'a str,
    #[serde(flatten)]
    setting: Setting,
    #[serde(flatten, serialize_with = "object")]
    cost: [(&'static str, u64); 1],
    error: Double,
    poisson: bool,
}

/// The run that comes nearest.
#[derive(Serialize)]
struct Nearest<'a> {
    name: &'a str,
    #[serde(flatten)]
    setting: Setting,
    error: Double,
    #[serde(serialize_with = "object")]
    drift: Vec<(String, Double)>,
    missed: &'a str,
    ratio: Double,
    limit: Limit,
    advice: &'static str,
}

/// The run of the scene that was written.
#[derive(Serialize)]
struct WrittenRun {
    #[serde(skip_serializing_if = "Option::is_none")]
    steps: Option<u64>,
    every: u64,
}

impl<'a> TuningJson<'a> {
    pub(super) fn of(found: &'a Found<'a>) -> Self {
        let tuning = found.tuning;
        let asked = tuning.asked;
        let reference = found.tuner.reference();
        let recommended = |r: Option<&'a Recommendation>| r.map(|r| Recommended::of(found, r));
        let runners_up = tuning.runners_up.iter();
        Self {
            outcome: match found.recommended() {
                Some(_) => "found",
                None => "not found",
            },
            scene: &found.document.name,
            time: Double(found.bench.time()),
            asked: Asked {
                error: asked.error.map(Double),
                errors: reference.judged().words(),
                energy: asked.energy.map(Double),
                casimir: asked.casimirs.map(Double),
                relative: asked.relative,
                poisson: !found.any,
            },
            reference: reference.into(),
            recommended: recommended(found.recommended()),
            cheapest_of_all: recommended(tuning.any.as_ref()),
            runners_up: runners_up.map(|runner| Runner::of(found, runner)).collect(),
            limit: tuning.limit,
            advice: tuning.limit.map(advice),
            horizon: tuning.horizon.as_ref().map(HorizonFields::from),
            nearest: tuning
                .nearest
                .as_ref()
                .map(|reached| Nearest::of(found, reached)),
            complete: tuning.is_complete,
            unbuilt: found.tuner.unbuilt(),
            methods: tuning.methods,
            runs: tuning.runs,
            costs_in: found.tuner.cost().word(),
            spent: tuning.spent,
            written: found.written.is_some(),
            written_run: found.written.as_ref().map(|scene| WrittenRun {
                steps: scene.run.until.is_none().then_some(scene.run.steps.value),
                every: scene.run.record.every,
            }),
        }
    }
}

impl<'a> Recommended<'a> {
    fn of(found: &Found<'a>, recommended: &'a Recommendation) -> Self {
        let cost = found.tuner.cost().word();
        Self {
            name: &recommended.name,
            method: recommended.method.text(recommended.time_step),
            steps: recommended.setting.steps,
            time_step: Double(recommended.time_step),
            tolerance: recommended.setting.tolerance.map(Double),
            predicted: recommended.predicted.map(|predicted| Predicted {
                error: Double(predicted.error),
                cost: [(cost, Double(predicted.cost))],
            }),
            measured: &recommended.measured,
        }
    }
}

impl<'a> Runner<'a> {
    fn of(found: &Found<'a>, runner: &'a RunnerUp) -> Self {
        Self {
            name: &runner.name,
            setting: runner.setting,
            cost: [(found.tuner.cost().word(), runner.cost)],
            error: Double(runner.error),
            poisson: runner.is_poisson,
        }
    }
}

impl<'a> Nearest<'a> {
    fn of(found: &Found<'a>, reached: &'a Reached) -> Self {
        let drift = reached.drift.iter().copied().map(Double);
        Self {
            name: &reached.name,
            setting: reached.setting,
            error: Double(reached.error),
            drift: found.bench.invariants().into_iter().zip(drift).collect(),
            missed: &reached.missed,
            ratio: Double(reached.ratio),
            limit: reached.limit,
            advice: advice(reached.limit),
        }
    }
}
