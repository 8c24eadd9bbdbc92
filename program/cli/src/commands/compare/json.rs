//! The object of `compare --json`.

use leafwise::core::Structure;
use leafwise::run::{json::json_number, json::json_numbers};
use leafwise::scene::SceneDocument;
use leafwise::trade::{Comparison, Horizon, Measured, Point, Reference};
use serde_json::{Value, json};

/// Everything that was measured.
pub(in crate::commands) fn object(document: &SceneDocument, comparison: &Comparison) -> Value {
    let methods: Vec<Value> = comparison
        .methods
        .iter()
        .map(|method| {
            json!({
                "name": method.name,
                "order": method.order,
                "structure": structure(method.structure),
                "is_own": method.is_own,
            })
        })
        .collect();
    let points: Vec<Value> = comparison
        .points
        .iter()
        .map(|point| point_json(comparison, point))
        .collect();
    let refused: Vec<Value> = comparison
        .refused
        .iter()
        .map(|(method, reason)| json!({ "method": method, "reason": reason }))
        .collect();
    json!({
        "outcome": "done",
        "scene": document.name,
        "time": json_number(comparison.time),
        "reference": reference(&comparison.reference),
        "horizon": comparison.horizon.as_ref().map(horizon),
        "budget": comparison.budget,
        "fronts_by": comparison.cost.word(),
        "methods": methods,
        "points": points,
        "refused": refused,
    })
}

/// The reference solution.
pub(in crate::commands) fn reference(reference: &Reference) -> Value {
    json!({
        "state": json_numbers(&reference.state),
        "error": json_number(reference.error),
        "floor": json_number(reference.floor()),
        "errors": reference.judged().words(),
        "methods": reference.methods,
    })
}

/// How long the motion can be known, and why no longer.
pub(in crate::commands) fn horizon(horizon: &Horizon) -> Value {
    json!({
        "wanted": json_number(horizon.wanted),
        "growth": horizon.growth.map(json_number),
        "known": horizon.known.map(|known| json!({
            "time": json_number(known.time), "error": json_number(known.error),
        })),
        "message": horizon.to_string(),
    })
}

/// The declared structure in a word.
pub(in crate::commands) fn structure(structure: Structure) -> String {
    match structure {
        Structure::Exact => "exact".to_owned(),
        Structure::Order(n) => format!("order {n}"),
        Structure::None => "none".to_owned(),
    }
}

fn point_json(comparison: &Comparison, point: &Point) -> Value {
    let mut object = json!({
        "method": comparison.methods[point.method].name,
        "steps": point.setting.steps,
        "time_step": json_number(point.time_step),
        "tolerance": point.setting.tolerance.map(json_number),
    });
    let fields = match &point.outcome {
        Ok(measured) => measured_json(measured),
        Err(failure) => json!({
            "failure": failure.to_string(),
            "over_budget": failure.is_over_budget(),
        }),
    };
    if let (Value::Object(object), Value::Object(fields)) = (&mut object, fields) {
        object.extend(fields);
    }
    object
}

/// What a run costs and what it keeps.
pub(in crate::commands) fn measured_json(measured: &Measured) -> Value {
    let wall = measured.wall.map(|wall| {
        json!({
            "median": wall.seconds, "spread": wall.spread, "repetitions": wall.repetitions,
        })
    });
    json!({
        "operations": measured.operations,
        "evaluations": measured.evaluations,
        "wall_seconds": wall,
        "error": json_number(measured.error),
        "relative_error": json_number(measured.relative_error),
        "end_error": json_number(measured.end_error),
        "at_floor": measured.at_floor,
        "energy_drift": json_number(measured.energy_drift),
        "casimir_drift": measured.casimir_drift.map(json_number),
        "tensor_defect": measured.tensor_defect.map(json_number),
        "poisson": measured.is_poisson,
        "front": {
            "all": measured.front.all,
            "poisson": measured.front.poisson,
            "wall": measured.front.wall,
        },
    })
}
