//! Settings on threads, their rows in order.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::checkpoint::Checkpoint;
use super::plan::ComposedSweep;
use super::row::{Row, Signals};
use crate::csv::Table;
use crate::ordered::{Turn, in_order};
use crate::shards::Found;
use crate::{Appended, CHECKPOINT, Progress, RunError, RunOutcome, SWEEP, Status};

/// How often a checkpoint is written.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

/// A sweep between two settings.
pub(super) struct Session<'a> {
    sweep: &'a ComposedSweep<'a>,
    directory: &'a Path,
    table: Appended,
    items: Range<u64>,
    /// The setting whose row is written next.
    pub next: u64,
    pub failed: u64,
    pub wall: Duration,
    pub threads: usize,
    largest: f64,
}

impl<'a> Session<'a> {
    /// No row yet.
    pub fn new(
        sweep: &'a ComposedSweep<'a>,
        directory: &'a Path,
        items: Range<u64>,
    ) -> Result<Self, RunError> {
        let mut table = Appended::create(&directory.join(SWEEP))?;
        table.push(sweep.columns().heading().as_bytes())?;
        table.flush()?;
        Ok(Self {
            sweep,
            directory,
            table,
            next: items.start,
            items,
            failed: 0,
            wall: Duration::ZERO,
            threads: 0,
            largest: 0.0,
        })
    }

    /// The rows of an earlier session; `None` where it was killed before its first checkpoint.
    pub fn resume(
        sweep: &'a ComposedSweep<'a>,
        directory: &'a Path,
        items: Range<u64>,
    ) -> Result<Option<Self>, RunError> {
        let path = directory.join(SWEEP);
        if !directory.join(CHECKPOINT).exists() {
            let begun = path.metadata().map_or(0, |file| file.len());
            if begun <= sweep.columns().heading().len() as u64 {
                return Ok(None);
            }
        }
        let checkpoint = Checkpoint::read(directory, sweep.settings().count(), &items)?;
        Ok(Some(Self {
            sweep,
            directory,
            table: Appended::resume(&path, &checkpoint.vouched)?,
            next: checkpoint.next,
            failed: checkpoint.failed,
            wall: Duration::from_secs_f64(f64::from_bits(checkpoint.wall_seconds).max(0.0)),
            items,
            threads: 0,
            largest: 0.0,
        }))
    }

    /// Runs the settings that are left, or as many as go before an interruption.
    pub fn drive(
        &mut self,
        threads: NonZeroUsize,
        progress: &mut dyn Progress,
    ) -> Result<RunOutcome, RunError> {
        self.table.cut(false)?;
        self.checkpoint()?;
        let directory = self.directory;
        let mut steps = || {
            let outcome = self.steps(threads, progress)?;
            self.checkpoint()?;
            Ok(outcome)
        };
        steps().map_err(|error: RunError| error.with_a_checkpoint(directory))
    }

    fn steps(
        &mut self,
        threads: NonZeroUsize,
        progress: &mut dyn Progress,
    ) -> Result<RunOutcome, RunError> {
        let signals = Signals::default();
        let (sweep, first) = (self.sweep, self.next);
        let work = |(): &mut (), task: u64| {
            let setting = first + task;
            match sweep.run(setting).map_err(RunError::Refused)? {
                Some(run) => Row::of(setting, &run, &signals),
                None => Ok(None),
            }
        };
        let each = sweep.base.plan.steps;
        let (total, done) = (self.items.end - self.items.start, first - self.items.start);
        let (started, before) = (Instant::now(), self.wall);
        let mut saved = Instant::now();
        let tasks = (self.items.end - first, threads);
        let turn = |turn: Turn<Row>| {
            match turn {
                Turn::Take(row) => self.take(&row)?,
                Turn::Look => {
                    self.wall = before + started.elapsed();
                    let made = signals.steps.load(Ordering::Relaxed);
                    progress.show(&Status {
                        steps: done.saturating_mul(each).saturating_add(made),
                        total: total.saturating_mul(each),
                        time: sweep.base.plan.epsilon * sweep.base.plan.h * each as f64,
                        until: None,
                        energy_drift: self.largest,
                    });
                    if saved.elapsed() >= CHECKPOINT_EVERY {
                        self.checkpoint()?;
                        saved = Instant::now();
                    }
                }
            }
            Ok(!progress.is_interrupted())
        };
        let (threads, outcome) = in_order(tasks, &signals.stop, work, turn);
        self.threads = threads;
        outcome
    }

    fn take(&mut self, row: &Row) -> Result<(), RunError> {
        let mut text = Table::default();
        row.write(self.sweep.settings(), &mut text);
        self.table.push(text.as_str().as_bytes())?;
        self.next += 1;
        self.failed += u64::from(row.has_failed());
        self.largest = self.largest.max(row.energy_drift());
        Ok(())
    }

    /// Takes in the rows of a shard, which follow.
    pub fn append(&mut self, shard: &Found) -> Result<(), RunError> {
        let (items, path) = (shard.items(), &shard.directory);
        if items.is_empty() {
            return Ok(());
        }
        let checkpoint = Checkpoint::read(path, self.sweep.settings().count(), &items)?;
        if checkpoint.next != items.end {
            return Err(RunError::Damaged {
                file: path.join(CHECKPOINT),
                reason: "it holds fewer settings than its manifest says".to_owned(),
            });
        }
        let heading = self.sweep.columns().heading().len() as u64;
        self.table
            .append_file(&path.join(SWEEP), &checkpoint.vouched, heading)?;
        self.next = items.end;
        self.failed += checkpoint.failed;
        self.wall += Duration::from_secs_f64(f64::from_bits(checkpoint.wall_seconds).max(0.0));
        Ok(())
    }

    /// Writes what a resumed session needs.
    pub fn checkpoint(&mut self) -> Result<(), RunError> {
        let checkpoint = Checkpoint {
            settings: self.sweep.settings().count(),
            first: self.items.start,
            next: self.next,
            failed: self.failed,
            wall_seconds: self.wall.as_secs_f64().to_bits(),
            vouched: self.table.sync()?,
        };
        checkpoint.write(self.directory)
    }
}
