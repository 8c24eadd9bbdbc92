//! Figures as one object.

use leafwise::report::Stroke;
use leafwise::reproduce::Reproduced;
use leafwise::run::json::json_number;
use serde_json::{Value, json};

/// `outcome`, `seconds` and `figures`.
pub(super) fn object(figures: &[Reproduced], seconds: f64) -> Value {
    let holds = figures.iter().all(Reproduced::holds);
    json!({
        "outcome": if holds { "met" } else { "not met" },
        "seconds": json_number(seconds),
        "figures": figures.iter().map(figure).collect::<Vec<Value>>(),
    })
}

fn figure(figure: &Reproduced) -> Value {
    let findings: Vec<Value> = figure
        .findings
        .iter()
        .map(|finding| {
            json!({
                "quantity": finding.claim.quantity,
                "printed": { "text": finding.claim.printed, "value": finding.claim.value },
                "measured": {
                    "text": finding.measured,
                    "value": finding.value.map(json_number),
                    "tolerance": finding.tolerance.map(json_number),
                },
                "theory": finding.explanation,
                "agrees": finding.agrees,
                "holds": finding.holds,
            })
        })
        .collect();
    let panels: Vec<Value> = figure
        .panels
        .iter()
        .map(|panel| {
            let series = panel.series.iter().filter(|s| s.stroke != Stroke::Guide);
            let series: Vec<Value> = series
                .map(|series| {
                    let points = series.points.iter();
                    let points = points.map(|(x, y)| json!([json_number(*x), json_number(*y)]));
                    json!({ "name": series.name, "points": points.collect::<Vec<Value>>() })
                })
                .collect();
            json!({
                "title": panel.title,
                "x": panel.x.title,
                "y": panel.y.title,
                "series": series,
            })
        })
        .collect();
    json!({
        "figure": figure.paper.number,
        "name": figure.paper.id,
        "section": figure.paper.section,
        "title": figure.paper.title,
        "setting": figure.paper.setting,
        "findings": findings,
        "panels": panels,
        "scene": figure.scene,
    })
}
