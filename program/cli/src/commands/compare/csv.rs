//! One line a point.

use leafwise::run::csv::Table;
use leafwise::trade::{Comparison, Measured};

const HEADINGS: [&str; 23] = [
    "method",
    "order",
    "structure",
    "steps",
    "time_step",
    "tolerance",
    "operations",
    "evaluations",
    "wall_seconds",
    "wall_spread",
    "repetitions",
    "error",
    "relative_error",
    "end_error",
    "at_floor",
    "energy_drift",
    "casimir_drift",
    "tensor_defect",
    "poisson",
    "front",
    "poisson_front",
    "wall_front",
    "failure",
];

/// Columns of what is measured: those between `tolerance` and `failure`.
const MEASURED: usize = 16;

/// All points; a point that failed has its reason in the last column.
pub(super) fn table(comparison: &Comparison) -> Table {
    let mut table = Table::new(HEADINGS);
    for point in &comparison.points {
        let method = &comparison.methods[point.method];
        table
            .text(&method.name)
            .whole(method.order as u64)
            .text(&method.structure.to_string())
            .whole(point.setting.steps)
            .number(point.time_step)
            .optional(point.setting.tolerance);
        match &point.outcome {
            Ok(measured) => {
                cells(&mut table, measured);
                table.text("");
            }
            Err(failure) => {
                (0..MEASURED).for_each(|_| {
                    table.text("");
                });
                table.text(&failure.to_string());
            }
        }
        table.end_row();
    }
    table
}

fn cells(table: &mut Table, measured: &Measured) {
    let (wall, front) = (measured.wall, &measured.front);
    let or_empty = |count: Option<u64>| count.map_or_else(String::new, |count| count.to_string());
    table
        .text(&or_empty(measured.operations))
        .whole(measured.evaluations)
        .optional(wall.map(|wall| wall.seconds))
        .optional(wall.map(|wall| wall.spread))
        .text(&or_empty(wall.map(|wall| wall.repetitions as u64)))
        .number(measured.error)
        .number(measured.relative_error)
        .number(measured.end_error)
        .text(word(measured.at_floor))
        .number(measured.energy_drift)
        .optional(measured.casimir_drift)
        .optional(measured.tensor_defect)
        .text(word(measured.is_poisson))
        .text(word(front.all))
        .text(word(front.poisson))
        .text(word(front.wall));
}

fn word(is_so: bool) -> &'static str {
    if is_so { "true" } else { "false" }
}
