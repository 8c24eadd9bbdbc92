//! Report of an ensemble that has ended.

use std::path::PathBuf;

use super::plan::ComposedEnsemble;
use super::statistics::Reductions;
use crate::advice::Advice;
use crate::shown::rounded;
use crate::{REPORT, RunOutcome};

/// An ensemble that has ended and left its directory complete.
#[derive(Clone, Debug)]
pub struct EnsembleReport {
    /// How it ended: done, or interrupted. Members that failed are reported in `reductions`.
    pub outcome: RunOutcome,
    /// Reductions over its members.
    pub reductions: Reductions,
    /// Crossings recorded, where there is a section.
    pub crossings: Option<u64>,
    /// Seconds of integration, observers and reductions included, all sessions together.
    pub wall_seconds: f64,
    /// The member an earlier session had come to.
    pub resumed_at: Option<u64>,
    /// Whether it was already complete: nothing was computed or written.
    pub is_repeated: bool,
    /// Threads that members were stepped on: fewer than asked for where the system grants no more.
    pub threads: usize,
    /// Advice on what to change in the scene, as the members have shown.
    pub advice: Vec<Advice>,
    /// The run directory.
    pub directory: PathBuf,
}

impl EnsembleReport {
    /// The page to open in a browser.
    pub fn report(&self) -> PathBuf {
        self.directory.join(REPORT)
    }

    /// Between which ranks the quantiles at the end lie, in words; `None` where they are those of the members themselves.
    pub fn ranks(&self, ensemble: &ComposedEnsemble) -> Option<String> {
        let parts = &ensemble.quantiles;
        let last = self.reductions.summaries.iter().rev();
        let last = last.take(ensemble.columns.len());
        let quantiles: Vec<_> = last.map(|summary| summary.quantiles(parts)).collect();
        let error = |at: usize| {
            quantiles
                .iter()
                .map(|of| of[at].rank_error)
                .fold(0.0, f64::max)
        };
        let errors: Vec<(f64, f64)> = parts.iter().copied().zip((0..).map(error)).collect();
        if errors.iter().all(|(_, error)| *error == 0.0) {
            return None;
        }
        let [within, deeper] = [false, true].map(|is_deeper| {
            let of = errors
                .iter()
                .filter(|(p, error)| (*error >= p.min(1.0 - p) && *error > 0.0) == is_deeper);
            let words = of.map(|(p, error)| match is_deeper {
                false => format!("{} ± {} %", percent(*p), percent(*error)),
                true => format!("{} %", percent(*p)),
            });
            words.collect::<Vec<_>>().join(", ")
        });
        let mut words = format!("of a sketch, their ranks {within} of the members");
        if within.is_empty() {
            "of a sketch".clone_into(&mut words);
        }
        if !deeper.is_empty() {
            words.push_str("; ");
            words.push_str(&deeper);
            words.push_str(" lies nearer to the end than the sketch resolves ranks");
        }
        Some(words)
    }

    /// Members a second.
    pub fn rate(&self) -> f64 {
        self.reductions.members as f64 / self.wall_seconds.max(1e-9)
    }
}

/// A part as a percentage of three digits.
pub(super) fn percent(part: f64) -> String {
    rounded(100.0 * part, 3)
}
