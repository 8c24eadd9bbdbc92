//! What an ensemble leaves behind.

use std::path::PathBuf;

use super::statistics::Reductions;
use crate::advice::Advice;
use crate::{REPORT, RunOutcome};

/// An ensemble that has ended and left its directory complete.
#[derive(Clone, Debug)]
pub struct EnsembleReport {
    /// How it ended: done, or interrupted. Members that failed are reported in `reductions`.
    pub outcome: RunOutcome,
    /// What its members were reduced to.
    pub reductions: Reductions,
    /// Crossings recorded, where there is a section.
    pub crossings: Option<u64>,
    /// Seconds of integration, observers and reductions included, all sessions together.
    pub wall_seconds: f64,
    /// The member an earlier session had come to.
    pub resumed_at: Option<u64>,
    /// Whether it had come to its end before: nothing was computed or written.
    pub is_repeated: bool,
    /// Threads that members were stepped on: fewer than asked for where the system grants no more.
    pub threads: usize,
    /// What to change in the scene, as the members have shown.
    pub advice: Vec<Advice>,
    /// The run directory.
    pub directory: PathBuf,
}

impl EnsembleReport {
    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join(REPORT)
    }

    /// Members a second.
    pub fn rate(&self) -> f64 {
        self.reductions.members as f64 / self.wall_seconds.max(1e-9)
    }
}
