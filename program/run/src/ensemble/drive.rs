//! Blocks of members on several threads, taken in by number.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::{Duration, Instant};

use super::block::{self, Signals};
use super::checkpoint::Checkpoint;
use super::plan::ComposedEnsemble;
use super::record::Record;
use super::section::SectionStore;
use super::store::FinalStore;
use super::tree::Tree;
use crate::{Progress, RunError, RunOutcome, Status};

/// How often a checkpoint is written.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

/// What writing it may take of the time, where that is more: one part in so many.
const SHARE: u32 = 20;

/// How often progress is shown.
const SHOW_EVERY: Duration = Duration::from_millis(50);

/// How an ensemble is computed. Its results do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workforce {
    /// Threads.
    pub threads: NonZeroUsize,
    /// Members side by side on a thread, at most.
    pub lanes: NonZeroUsize,
}

impl Default for Workforce {
    /// All of the machine's threads, 64 members each.
    fn default() -> Self {
        let one = NonZeroUsize::MIN;
        Self {
            threads: std::thread::available_parallelism().unwrap_or(one),
            lanes: one.saturating_add(63),
        }
    }
}

/// Blocks that wait for one before them, at most, for each thread.
const WAITING: usize = 4;

/// An ensemble between two members.
pub(super) struct Session<'a> {
    pub ensemble: &'a ComposedEnsemble,
    pub tree: Tree,
    pub store: FinalStore,
    pub section: SectionStore,
    /// Where it is written.
    pub directory: &'a Path,
    pub wall: Duration,
    /// Threads that the members were stepped on.
    pub threads: usize,
    /// The member behind the last.
    pub end: u64,
}

impl Session<'_> {
    /// Steps all members that are left, or as many as go before an interruption; `save` writes a
    /// checkpoint.
    pub fn drive(
        &mut self,
        workforce: Workforce,
        progress: &mut dyn Progress,
        save: &mut dyn FnMut(&Checkpoint) -> Result<(), RunError>,
    ) -> Result<RunOutcome, RunError> {
        let (begun, members) = (self.tree.members().start, self.end);
        // Where steps are not counted, members are.
        let steps = self.ensemble.steps().unwrap_or(1);
        let from = self.tree.next();
        let blocks = blocks(from, members, workforce);
        let signals = Signals::default();
        let (next, taken) = (AtomicU64::new(0), AtomicU64::new(0));
        let (sender, receiver) = channel::<(u64, Result<Option<Record>, RunError>)>();
        let (ensemble, directory) = (self.ensemble, self.directory);
        let most_waiting = (workforce.threads.get().saturating_mul(WAITING)) as u64;
        let next_block = || {
            let block = next.fetch_add(1, Ordering::Relaxed);
            let (first, lanes) = blocks.at(block)?;
            // Blocks far ahead of the slowest wait, so that few are held in memory.
            while block > taken.load(Ordering::Relaxed).saturating_add(most_waiting) {
                if signals.stop.load(Ordering::Relaxed) {
                    return None;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            Some((
                block,
                block::run(ensemble, directory, (first, lanes), &signals),
            ))
        };
        let work = || {
            while let Some((block, record)) = next_block() {
                let is_over = !matches!(record, Ok(Some(_)));
                if sender.clone().send((block, record)).is_err() || is_over {
                    return;
                }
            }
        };
        std::thread::scope(|scope| {
            // As many as there are blocks, and as many as the system grants; without any, blocks are
            // stepped here.
            let threads = 0..blocks.count().min(workforce.threads.get() as u64);
            let spawn = |_| Builder::new().spawn_scoped(scope, work).ok();
            let workers: Vec<_> = threads.map_while(spawn).collect();
            self.threads = workers.len().max(1);
            let mut waiting = BTreeMap::new();
            let (mut at, started) = (0, Instant::now());
            let before = self.wall;
            let (mut saved, mut took) = (Instant::now(), Duration::ZERO);
            let mut is_stuck = false;
            let outcome = loop {
                if at == blocks.count() {
                    break Ok(RunOutcome::Done);
                }
                if progress.is_interrupted() {
                    break Ok(RunOutcome::Interrupted);
                }
                let received = if workers.is_empty() {
                    next_block().ok_or(RecvTimeoutError::Disconnected)
                } else {
                    receiver.recv_timeout(SHOW_EVERY)
                };
                match received {
                    Ok((block, Ok(Some(record)))) => {
                        waiting.insert(block, record);
                        is_stuck = false;
                    }
                    Ok((_, Err(error))) => break Err(error),
                    Ok((_, Ok(None))) => {}
                    // A worker that panicked leaves its block out: the panic goes on below.
                    Err(_) if workers.iter().all(|worker| worker.is_finished()) && is_stuck => {
                        break Ok(RunOutcome::Interrupted);
                    }
                    Err(_) => is_stuck = true,
                }
                let mut result = Ok(());
                while let Some(mut record) = waiting.remove(&at) {
                    result = self.take(&mut record);
                    at += 1;
                    taken.store(at, Ordering::Relaxed);
                }
                self.wall = before + started.elapsed();
                progress.show(&Status {
                    steps: (from - begun)
                        .saturating_mul(steps)
                        .saturating_add(signals.steps.load(Ordering::Relaxed)),
                    total: (members - begun).saturating_mul(steps),
                    time: ensemble.end(),
                    until: None,
                    energy_drift: self.tree.largest_deviation(),
                });
                if result.is_ok() && saved.elapsed() >= CHECKPOINT_EVERY.max(SHARE * took) {
                    let begun = Instant::now();
                    result = self.checkpoint().and_then(|checkpoint| save(&checkpoint));
                    (saved, took) = (Instant::now(), begun.elapsed());
                }
                if let Err(error) = result {
                    break Err(error);
                }
            };
            signals.stop.store(true, Ordering::Relaxed);
            outcome
        })
    }

    /// Takes a block in.
    fn take(&mut self, record: &mut Record) -> Result<(), RunError> {
        record.fold(self.ensemble, &mut self.tree);
        self.section.push(&mut record.crossings)?;
        self.store.push(self.ensemble, record)
    }

    /// What a resumed session needs.
    pub fn checkpoint(&mut self) -> Result<Checkpoint, RunError> {
        Ok(Checkpoint {
            fingerprint: self.ensemble.population.fingerprint(),
            members: self.ensemble.population.members(),
            wall_seconds: self.wall.as_secs_f64(),
            vouched: self.store.sync()?,
            section: self.section.sync()?,
            crossings: self.section.count,
            tree: self.tree.clone(),
        })
    }
}

/// The members from one on, in blocks.
struct Blocks {
    from: u64,
    members: u64,
    lanes: u64,
}

fn blocks(from: u64, members: u64, workforce: Workforce) -> Blocks {
    let threads = workforce.threads.get() as u64;
    // Few members: smaller blocks, so that every thread has some.
    let share = (members - from).div_ceil(2 * threads).max(1);
    Blocks {
        from,
        members,
        lanes: share.min(workforce.lanes.get() as u64),
    }
}

impl Blocks {
    fn count(&self) -> u64 {
        (self.members - self.from).div_ceil(self.lanes)
    }

    fn at(&self, block: u64) -> Option<(u64, usize)> {
        let first = block.checked_mul(self.lanes)?.checked_add(self.from)?;
        let left = self.members.checked_sub(first).filter(|left| *left > 0)?;
        Some((first, left.min(self.lanes) as usize))
    }
}
