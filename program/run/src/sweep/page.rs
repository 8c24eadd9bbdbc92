//! Page of a sweep's report: the data that it shows.

use leafwise_expression::words::counted;

use super::plan::ComposedSweep;
use super::report::SweepReport;
use crate::csv::rows;
use crate::{PROGRAM_VERSION, RunOutcome, file_name, method_lines, title};
use leafwise_report::{Outcome, SweepData, SweptColumn, SweptDirection, SweptKind};
use leafwise_scene::document::SceneDocument;

/// Failed settings that the page lists.
const MOST_SHOWN: usize = 50;

/// Directions that a page can draw.
const MOST_DIRECTIONS: usize = 2;

/// Gathers the report of a sweep that has ended, from its table.
pub(super) fn data(
    document: &SceneDocument,
    sweep: &ComposedSweep<'_>,
    report: &SweepReport,
    table: &str,
    command: &str,
) -> SweepData {
    // The table is this program's.
    let rows = rows(table).unwrap_or_default();
    let rows = rows.get(1..).unwrap_or(&[]);
    let columns = sweep.columns();
    let keys = columns.settings.len();
    let cells = |at: usize| rows.iter().map(move |row| row[at].as_str());
    let numbers = |at: usize| -> Vec<f64> {
        cells(at)
            .map(|cell| cell.parse().unwrap_or(f64::NAN))
            .collect()
    };
    let column = |(at, name): (usize, &String), kind| SweptColumn {
        name: name.clone(),
        values: numbers(at),
        kind,
    };
    let first = 1 + keys + 3;
    let drifts = columns.drifts.iter().enumerate();
    let drifts = drifts.map(|(k, name)| column((first + k, name), SweptKind::Drift));
    let behind = first + columns.drifts.len();
    let observables = columns.observables.iter().enumerate();
    let observables =
        observables.map(|(k, name)| column((behind + k, name), SweptKind::Observable));
    let evaluations = column(
        (first + columns.measured().len() + 1, &columns.cost[1]),
        SweptKind::Cost,
    );
    let directions: Vec<SweptDirection> = (0..keys)
        .map(|k| SweptDirection::of(&columns.settings[k], cells(1 + k)))
        .filter(|direction| direction.labels.len() > 1)
        .collect();
    let failures = rows.iter().filter(|row| row[1 + keys] == "failed");
    let failures = failures.take(MOST_SHOWN).map(|row| {
        let values = columns.settings.iter().zip(&row[1..]);
        let values: Vec<String> = values
            .map(|(key, value)| format!("{} = {value}", short_key(key)))
            .collect();
        (
            format!("{}: {}", row[0], values.join(", ")),
            row[2 + keys].clone(),
        )
    });
    let line = |label: &str, text: String| (label.to_owned(), text);
    let settings = counted(report.settings as usize, "setting");
    SweepData {
        title: title(&document.name),
        version: format!("leafwise {PROGRAM_VERSION}"),
        command: command.to_owned(),
        scene_name: file_name(&document.name),
        scene_text: document.text.clone(),
        outcome: match report.outcome {
            RunOutcome::Interrupted => Outcome::Interrupted {
                message: format!(
                    "after {} of {settings}; the same command resumes",
                    report.done
                ),
            },
            _ => Outcome::Done {
                message: format!("{settings}, {} failed", report.failed),
            },
        },
        facts: [
            line(
                "Settings",
                format!(
                    "{} of {}, {} failed",
                    report.done, report.settings, report.failed
                ),
            ),
            line(
                "Integration",
                format!(
                    "{:.3} s, {:.0} settings a second",
                    report.wall_seconds,
                    report.rate()
                ),
            ),
        ]
        .into_iter()
        // What no command has written is in a directory of the moment.
        .chain((!command.is_empty()).then(|| line("Data", report.table().display().to_string())))
        .collect(),
        method: method_lines(&sweep.base),
        is_drawn: (1..=MOST_DIRECTIONS).contains(&directions.len()),
        directions,
        columns: drifts.chain(observables).chain([evaluations]).collect(),
        failures: failures.collect(),
    }
}

/// The last name of a dotted key.
fn short_key(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, last)| last)
}
