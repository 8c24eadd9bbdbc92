//! The survey as one object.

use leafwise::run::json::json_number;
use leafwise::verify::{Measured, MeasuredOrder, Survey};
use serde_json::{Value, json};

/// `outcome`, `seconds`, `rows` and `refused`.
pub(super) fn object(survey: &Survey, seconds: f64) -> Value {
    let rows: Vec<Value> = survey
        .rows
        .iter()
        .map(|row| {
            json!({
                "problem": row.problem,
                "map": row.map,
        "is_own": row.is_own,
                "met": row.is_met(),
                "declared": { "order": row.declared_order, "structure": row.declared_structure },
                "measured": row.measured.as_ref().map(measured),
                "failure": row.failure,
                "seconds": json_number(row.seconds),
            })
        })
        .collect();
    let refused: Vec<Value> = survey
        .refused
        .iter()
        .map(|refused| {
            json!({
                "problem": refused.problem,
                "combination": refused.combination,
                "reason": refused.reason,
            })
        })
        .collect();
    json!({
        "outcome": if survey.is_met() { "met" } else { "not met" },
        "seconds": json_number(seconds),
        "rows": rows,
        "refused": refused,
    })
}

fn measured(measured: &Measured) -> Value {
    let errors: Vec<Value> = measured
        .errors
        .iter()
        .map(|(t, error)| json!([json_number(*t), json_number(*error)]))
        .collect();
    json!({
        "order": order(measured.order),
        "errors": errors,
        "structure": order(measured.structure),
        "time_step": json_number(measured.time_step),
        "too_large": measured.too_large,
        "broken_solve": measured.broken_solve,
        "tensor_defect": measured.tensor_defect.map(json_number),
        "self_adjointness": json_number(measured.self_adjointness),
        "casimir_drift": json_number(measured.casimir_drift),
        "energy_drift": json_number(measured.energy_drift),
        "energy_growth": measured.energy_growth.map(json_number),
        "evaluations_per_step": json_number(measured.evaluations_per_step),
        "nanoseconds_per_step": json_number(measured.nanoseconds_per_step),
        "judgements": {
            "order": measured.judgements[0],
            "structure": measured.judgements[1],
            "self_adjoint": measured.judgements[2],
        },
    })
}

fn order(order: MeasuredOrder) -> Value {
    json!({
        "exponent": order.exponent.map(json_number),
        "tolerance": order.tolerance.map(json_number),
        "at_least": order.at_least.map(json_number),
    })
}
