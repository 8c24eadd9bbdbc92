//! The object of `tune --json`.

use leafwise::run::json::json_number;
use leafwise::trade::{Limit, Reached, Recommendation, RunnerUp};
use serde_json::{Value, json};

use super::Found;
use super::text::advice;
use crate::commands::compare::json::{horizon, measured_json, reference};

/// Everything that was found.
pub(super) fn object(found: &Found<'_>) -> Value {
    let tuning = found.tuning;
    let asked = tuning.asked;
    let recommended = found.recommended();
    let runners_up: Vec<Value> = tuning
        .runners_up
        .iter()
        .map(|runner| runner_up(found, runner))
        .collect();
    json!({
        "outcome": if recommended.is_some() { "found" } else { "not found" },
        "scene": found.document.name,
        "time": json_number(found.bench.time()),
        "asked": {
            "error": asked.error.map(json_number),
            "errors": found.tuner.reference().judged().words(),
            "energy": asked.energy.map(json_number),
            "casimir": asked.casimirs.map(json_number),
            "relative": asked.relative,
            "poisson": !found.any,
        },
        "reference": reference(found.tuner.reference()),
        "recommended": recommended.map(|r| recommendation(found, r)),
        "cheapest_of_all": tuning.any.as_ref().map(|r| recommendation(found, r)),
        "runners_up": runners_up,
        "limit": tuning.limit.map(limit),
        "advice": tuning.limit.map(advice),
        "horizon": tuning.horizon.as_ref().map(horizon),
        "nearest": tuning.nearest.as_ref().map(|reached| nearest(found, reached)),
        "complete": tuning.is_complete,
        "unbuilt": found.tuner.unbuilt(),
        "methods": tuning.methods,
        "runs": tuning.runs,
        "costs_in": found.tuner.cost().word(),
        "spent": tuning.spent,
        "written": found.written.is_some(),
        "written_run": found.written.as_ref().map(|scene| json!({
            "steps": scene.run.steps.value,
            "every": scene.run.record.every,
        })),
    })
}

fn recommendation(found: &Found<'_>, recommended: &Recommendation) -> Value {
    let cost = found.tuner.cost().word();
    json!({
        "name": recommended.name,
        "method": recommended.method.text(recommended.time_step),
        "steps": recommended.setting.steps,
        "time_step": json_number(recommended.time_step),
        "tolerance": recommended.setting.tolerance.map(json_number),
        "predicted": recommended.predicted.map(|predicted| json!({
            "error": json_number(predicted.error),
            cost: json_number(predicted.cost),
        })),
        "measured": measured_json(&recommended.measured),
    })
}

fn runner_up(found: &Found<'_>, runner: &RunnerUp) -> Value {
    json!({
        "name": runner.name,
        "steps": runner.setting.steps,
        "tolerance": runner.setting.tolerance.map(json_number),
        found.tuner.cost().word(): runner.cost,
        "error": json_number(runner.error),
        "poisson": runner.is_poisson,
    })
}

fn nearest(found: &Found<'_>, reached: &Reached) -> Value {
    let names = found.bench.invariants();
    let drift = names.into_iter().zip(&reached.drift);
    let drift: serde_json::Map<String, Value> = drift
        .map(|(name, drift)| (name, json_number(*drift)))
        .collect();
    json!({
        "name": reached.name,
        "steps": reached.setting.steps,
        "tolerance": reached.setting.tolerance.map(json_number),
        "error": json_number(reached.error),
        "drift": drift,
        "missed": reached.missed,
        "ratio": json_number(reached.ratio),
        "limit": limit(reached.limit),
        "advice": advice(reached.limit),
    })
}

/// What keeps a method from what is asked, in a word.
fn limit(limit: Limit) -> &'static str {
    match limit {
        Limit::Reference => "reference",
        Limit::RoundOff => "round-off",
        Limit::Budget => "budget",
        Limit::Ended => "time",
        Limit::Failure => "failure",
        Limit::Structure => "structure",
    }
}
