//! Settings on threads, their rows in order.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::checkpoint::Checkpoint;
use super::plan::ComposedSweep;
use super::report::{SWEEP, SweepReport};
use super::row::{Row, Signals};
use crate::csv::Table;
use crate::job::shards::Found;
use crate::job::{Due, Folder, Held, JobSession};
use crate::ordered::{Turn, in_order};
use crate::{Appended, Progress, RunError, RunOutcome, Status};

/// A sweep between two settings.
pub struct Session<'a> {
    sweep: &'a ComposedSweep<'a>,
    /// Threads that were asked for, and as many as there were.
    wanted: NonZeroUsize,
    threads: usize,
    folder: Folder,
    table: Appended,
    items: Range<u64>,
    /// The setting whose row is written next.
    next: u64,
    failed: u64,
    wall: Duration,
    largest: f64,
    /// The setting that an earlier session had come to.
    resumed_at: Option<u64>,
}

/// Whether a directory holds no row.
pub(super) fn has_begun_at_most(sweep: &ComposedSweep<'_>, directory: &Path) -> bool {
    let begun = directory.join(SWEEP).metadata();
    begun.map_or(0, |file| file.len()) <= sweep.columns().heading().len() as u64
}

impl<'a> Session<'a> {
    /// No row yet.
    pub fn begin(
        sweep: &'a ComposedSweep<'a>,
        folder: &Folder,
        items: Range<u64>,
        wanted: NonZeroUsize,
    ) -> Result<Self, RunError> {
        let mut table = Appended::create(&folder.join(SWEEP))?;
        table.push(sweep.columns().heading().as_bytes())?;
        table.flush()?;
        Ok(Self {
            sweep,
            wanted,
            folder: folder.clone(),
            table,
            next: items.start,
            items,
            failed: 0,
            wall: Duration::ZERO,
            threads: 0,
            largest: 0.0,
            resumed_at: None,
        })
    }

    /// The rows of an earlier session; none is changed before [`go_on`](JobSession::go_on).
    pub fn resume(
        sweep: &'a ComposedSweep<'a>,
        folder: &Folder,
        items: Range<u64>,
        wanted: NonZeroUsize,
    ) -> Result<Self, RunError> {
        let checkpoint = Checkpoint::read(folder, sweep.settings().count(), &items)?;
        Ok(Self {
            sweep,
            wanted,
            folder: folder.clone(),
            table: Appended::resume(&folder.join(SWEEP), &checkpoint.vouched)?,
            next: checkpoint.next,
            failed: checkpoint.failed,
            wall: checkpoint.wall(),
            items,
            threads: 0,
            largest: 0.0,
            resumed_at: Some(checkpoint.next),
        })
    }

    /// Report of the sweep as the session leaves it.
    pub fn report(&self, outcome: RunOutcome, is_repeated: bool) -> SweepReport {
        SweepReport {
            outcome,
            settings: self.items.end - self.items.start,
            done: self.next - self.items.start,
            failed: self.failed,
            wall_seconds: self.wall.as_secs_f64(),
            resumed_at: self.resumed_at.filter(|_| !is_repeated),
            is_repeated,
            threads: self.threads,
            columns: self.sweep.columns().clone(),
            directory: self.folder.to_path_buf(),
        }
    }

    /// Whether all settings have rows.
    pub fn is_at_end(&self) -> bool {
        self.next == self.items.end
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
    pub(crate) fn append(&mut self, shard: &Found) -> Result<(), RunError> {
        let (items, path) = (shard.items(), &shard.directory);
        let checkpoint = Checkpoint::read(
            &self.folder.beside(path),
            self.sweep.settings().count(),
            &items,
        )?;
        if checkpoint.next != items.end {
            return Err(shard.holds_fewer());
        }
        let heading = self.sweep.columns().heading().len() as u64;
        self.table
            .append_file(&path.join(SWEEP), &checkpoint.vouched, heading)?;
        self.next = items.end;
        self.failed += checkpoint.failed;
        self.wall += checkpoint.wall();
        Ok(())
    }

    /// Writes what a resumed session needs.
    pub fn save(&mut self) -> Result<(), RunError> {
        let checkpoint = Checkpoint {
            settings: self.sweep.settings().count(),
            first: self.items.start,
            next: self.next,
            failed: self.failed,
            wall_seconds: self.wall.as_secs_f64().to_bits(),
            vouched: self.table.sync()?,
        };
        checkpoint.write(&self.folder)
    }
}

impl JobSession for Session<'_> {
    fn repeat(&mut self, held: &Held) -> Result<Option<RunOutcome>, RunError> {
        if !held.is_done || !self.is_at_end() {
            return Ok(None);
        }
        self.table.confirm_end()?;
        Ok(Some(RunOutcome::Done))
    }

    fn go_on(&mut self, _: &Held) -> Result<(), RunError> {
        // Rows that the checkpoint does not count go.
        self.table.cut(false)
    }

    /// Runs the settings that are left, or as many as go before an interruption, with checkpoints.
    fn drive(&mut self, progress: &mut dyn Progress) -> Result<RunOutcome, RunError> {
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
        let mut due = Due::new();
        let tasks = (self.items.end - first, self.wanted);
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
                    due.save(|| self.save())?;
                }
            }
            Ok(!progress.is_interrupted())
        };
        let (threads, outcome) = in_order(tasks, &signals.stop, work, turn);
        self.threads = threads;
        let outcome = outcome?;
        self.save()?;
        Ok(outcome)
    }
}
