//! One line a point.

use std::fmt::Write as _;

use leafwise::trade::{Comparison, Measured, Point};

use super::json::structure;

const HEADINGS: &str = "method,order,structure,steps,time_step,tolerance,operations,evaluations,\
                        wall_seconds,wall_spread,repetitions,error,relative_error,end_error,at_floor,\
                        energy_drift,casimir_drift,tensor_defect,poisson,front,poisson_front,\
                        wall_front,failure\n";

/// All points; a point that failed has its reason in the last column.
pub(super) fn text(comparison: &Comparison) -> String {
    let mut text = HEADINGS.to_owned();
    for point in &comparison.points {
        let method = &comparison.methods[point.method];
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "{},{},{},{},{},{},",
            quoted(&method.name),
            method.order,
            structure(method.structure),
            point.setting.steps,
            point.time_step,
            point.setting.tolerance.map_or_else(String::new, number),
        );
        text.push_str(&outcome(point));
        text.push('\n');
    }
    text
}

fn outcome(point: &Point) -> String {
    match &point.outcome {
        Ok(measured) => cells(measured).join(","),
        Err(failure) => format!("{}{}", ",".repeat(16), quoted(&failure.to_string())),
    }
}

fn cells(measured: &Measured) -> [String; 17] {
    let wall = measured.wall;
    let or_empty = |value: Option<f64>| value.map_or_else(String::new, number);
    [
        measured
            .operations
            .map_or_else(String::new, |count| count.to_string()),
        measured.evaluations.to_string(),
        or_empty(wall.map(|wall| wall.seconds)),
        or_empty(wall.map(|wall| wall.spread)),
        wall.map_or_else(String::new, |wall| wall.repetitions.to_string()),
        number(measured.error),
        number(measured.relative_error),
        number(measured.end_error),
        measured.at_floor.to_string(),
        number(measured.energy_drift),
        or_empty(measured.casimir_drift),
        or_empty(measured.tensor_defect),
        measured.is_poisson.to_string(),
        measured.front.all.to_string(),
        measured.front.poisson.to_string(),
        measured.front.wall.to_string(),
        String::new(),
    ]
}

fn number(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
