//! `leafwise stress`: the extremes, each with its expected outcome, row by row as they are run.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use leafwise::scene::json::double;
use leafwise::stress::{Case, Outcome, StressOptions, cases};
use serde::Serialize;

use crate::arguments::StressArguments;
use crate::bar::Steps;
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::table::{duration, labelled};

/// A case that was run.
#[derive(Serialize)]
struct Row {
    #[serde(flatten)]
    case: &'static Case,
    #[serde(flatten)]
    outcome: Outcome,
    #[serde(serialize_with = "double")]
    seconds: f64,
}

/// The object of `stress --json`.
#[derive(Serialize)]
struct StressJson<'a> {
    outcome: &'static str,
    #[serde(serialize_with = "double")]
    seconds: f64,
    cases: &'a [Row],
}

/// The object of `stress --list --json`.
#[derive(Serialize)]
struct Listed<'a> {
    cases: &'a [&'static Case],
}

/// Runs cases; returns the exit code.
///
/// # Errors
/// [`Failure`] for a name that no case has.
pub fn execute(
    arguments: &StressArguments,
    console: &mut Console<'_>,
    interrupt: &Arc<AtomicBool>,
) -> Result<u8, Failure> {
    let chosen = chosen(&arguments.cases)?;
    if arguments.list {
        list(&chosen, arguments.json, console);
        return Ok(exit::DONE);
    }
    let options = if arguments.long {
        StressOptions::LONG
    } else {
        StressOptions::SHORT
    };
    let started = Instant::now();
    let mut rows = Vec::with_capacity(chosen.len());
    for (at, case) in chosen.iter().copied().enumerate() {
        if interrupt.load(Ordering::Relaxed) {
            return Ok(exit::INTERRUPTED);
        }
        let mut bar = Steps::new("", console.shown(false));
        bar.show(&case.id(), at, chosen.len());
        let begun = Instant::now();
        let outcome = case.run(&options);
        bar.finish();
        let row = Row {
            case,
            outcome,
            seconds: begun.elapsed().as_secs_f64(),
        };
        if !arguments.json {
            print(&row, console);
        }
        rows.push(row);
    }
    let seconds = started.elapsed().as_secs_f64();
    let failing = rows.iter().filter(|row| !row.outcome.is_met).count();
    if arguments.json {
        console.json(&StressJson {
            outcome: if failing == 0 { "met" } else { "not met" },
            seconds,
            cases: &rows,
        });
    } else {
        let count = rows.len();
        console.result(&match failing {
            0 => format!("{count} cases met, in {}", duration(seconds)),
            _ => format!(
                "{failing} of {count} cases not met, in {}",
                duration(seconds)
            ),
        });
    }
    Ok(if failing == 0 {
        exit::DONE
    } else {
        exit::CHECK_FAILED
    })
}

/// The cases that the command line names, in the table's order.
fn chosen(names: &[String]) -> Result<Vec<&'static Case>, Failure> {
    let unknown = names
        .iter()
        .find(|name| !cases().any(|case| case.is_called(name)));
    if let Some(name) = unknown {
        let mut families: Vec<&str> = cases().map(|case| case.family).collect();
        families.dedup();
        return Err(Failure::usage(
            format!("no case is called `{name}`"),
            format!(
                "the families are {}; `leafwise stress --list` prints every case",
                families.join(", ")
            ),
        ));
    }
    let is_chosen =
        |case: &&'static Case| names.is_empty() || names.iter().any(|name| case.is_called(name));
    Ok(cases().filter(is_chosen).collect())
}

fn list(chosen: &[&'static Case], json: bool, console: &mut Console<'_>) {
    if json {
        console.json(&Listed { cases: chosen });
        return;
    }
    for case in chosen {
        console.result(&case.id());
        for line in labelled(&[("asked", case.asked), ("expected", case.expected)]) {
            console.result(&format!("    {line}"));
        }
    }
}

fn print(row: &Row, console: &mut Console<'_>) {
    let mark = if row.outcome.is_met { "ok   " } else { "FAILS" };
    console.result(&format!(
        "{mark} {}  ({})",
        row.case.id(),
        duration(row.seconds)
    ));
    for line in labelled(&[
        ("asked", row.case.asked),
        ("expected", row.case.expected),
        ("measured", row.outcome.measured.as_str()),
    ]) {
        console.result(&format!("      {line}"));
    }
    console.result("");
}
