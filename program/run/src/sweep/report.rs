//! Report of a sweep that has ended.

use std::path::PathBuf;

use serde::Serialize;

use super::columns::SweepColumns;
use crate::{REPORT, RunOutcome};

/// The table: a row for each setting.
pub(super) const SWEEP: &str = "sweep.csv";

/// A sweep that has ended and left its directory complete.
#[derive(Clone, Debug)]
pub struct SweepReport {
    /// How it ended: done, or interrupted. A setting whose run failed is a row.
    pub outcome: RunOutcome,
    /// The settings that were asked for, of the sweep or of a shard of it.
    pub settings: u64,
    /// How many of them have rows.
    pub done: u64,
    /// How many of these have failed.
    pub failed: u64,
    /// Seconds of all runs, building apart; all sessions together.
    pub wall_seconds: f64,
    /// The setting an earlier session had come to.
    pub resumed_at: Option<u64>,
    /// Whether it was already complete: nothing was computed or written.
    pub is_repeated: bool,
    /// Threads that settings were run on.
    pub threads: usize,
    /// The columns of the table.
    pub columns: SweepColumns,
    /// The run directory.
    pub directory: PathBuf,
}

impl SweepReport {
    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join(REPORT)
    }

    /// The table.
    pub fn table(&self) -> PathBuf {
        self.directory.join(SWEEP)
    }

    /// Settings a second.
    pub fn rate(&self) -> f64 {
        self.done as f64 / self.wall_seconds.max(1e-9)
    }
}

/// The end of a sweep's manifest; the object of `sweep --json`, but for its directory.
#[derive(Clone, Debug, Serialize)]
pub struct SweepEnding<'a> {
    settings: u64,
    done: u64,
    failed: u64,
    wall_seconds: f64,
    table: &'static str,
    columns: &'a SweepColumns,
    outcome: &'static str,
}

impl<'a> SweepEnding<'a> {
    /// Describes a sweep that has ended.
    pub fn new(report: &'a SweepReport) -> Self {
        Self {
            settings: report.settings,
            done: report.done,
            failed: report.failed,
            wall_seconds: report.wall_seconds,
            table: SWEEP,
            columns: &report.columns,
            outcome: report.outcome.word(),
        }
    }
}
