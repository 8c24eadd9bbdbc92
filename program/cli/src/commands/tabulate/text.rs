//! Lines that `tabulate` prints.

use leafwise::learn::{ManySteps, Region, Tabulated};

use super::cost::{Cost, Steps};
use crate::table::{duration, short, words};

/// The table as lines.
pub(super) fn lines(
    table: &Tabulated,
    steps: &ManySteps<'_>,
    cost: &Cost,
    region: &Region,
    names: &[String],
) -> Vec<String> {
    let learned = &table.learned;
    let mut lines = vec![
        format!(
            "Table of {} steps, a time of {}: {} functions from {} pairs",
            steps.count,
            short(steps.duration()),
            learned.functions.len(),
            learned.pairs
        ),
        String::new(),
    ];
    if let Region::Box(bounds) = region {
        let rows = names.iter().zip(bounds).map(|(name, (least, largest))| {
            vec![
                format!("  {name}"),
                format!("{} … {}", short(*least), short(*largest)),
            ]
        });
        lines.extend(words(&rows.collect::<Vec<_>>()));
        lines.push(String::new());
    }
    let row = |name: &str, value: f64, meaning: String| {
        vec![format!("  {name}"), format!("{value:.1e}"), meaning]
    };
    let mut rows = vec![
        row(
            "motion",
            learned.motion,
            "x' - x, root mean square".to_owned(),
        ),
        row(
            "error",
            table.error,
            format!(
                "the table less the steps, root mean square at {} states that no pair has",
                table.unseen.len() - table.failed
            ),
        ),
        row("largest error", table.largest_error, "of these".to_owned()),
    ];
    if let Some(determinant) = table.determinant {
        rows.push(vec![
            "  chart".to_owned(),
            format!("{determinant:.3}"),
            "least |det(1 + DΦ)|: 1 for no motion, 0 where the chart ends".to_owned(),
        ]);
    }
    lines.extend(words(&rows));
    lines.push(String::new());
    lines.push("Time for each state, over one step of the table:".to_owned());
    let taken = |own: Steps, what: String| {
        vec![
            format!("  {what}"),
            duration(own.seconds),
            format!("{:.1} ×", own.seconds / cost.table),
        ]
    };
    let mut rows = vec![
        vec![
            "  the table".to_owned(),
            duration(cost.table),
            "1.0 ×".to_owned(),
        ],
        taken(cost.own, format!("{} steps", steps.count)),
    ];
    if cost.fewest.count < steps.count {
        rows.push(taken(
            cost.fewest,
            format!(
                "{} longer ones, with an error of {:.1e}",
                cost.fewest.count, cost.fewest.error
            ),
        ));
    }
    lines.extend(words(&rows));
    lines
}
