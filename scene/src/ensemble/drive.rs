//! Blocks of members on several threads, taken in by number.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use leafwise_core::BuildError;

use super::block::{self, Record, Signals};
use super::checkpoint::Checkpoint;
use super::plan::ComposedEnsemble;
use super::statistics::Reductions;
use super::store::FinalStore;
use crate::run::{Progress, RunError, RunOutcome, Status};

/// How often a checkpoint is written.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

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
    pub reductions: Reductions,
    pub store: FinalStore,
    pub wall: Duration,
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
        let members = self.ensemble.population.members();
        let steps = self.ensemble.run.plan.steps;
        let from = self.reductions.members;
        let blocks = blocks(from, members, workforce);
        let signals = Signals::default();
        let (next, taken) = (AtomicU64::new(0), AtomicU64::new(0));
        let (sender, receiver) = channel::<(u64, Result<Option<Record>, BuildError>)>();
        let ensemble = self.ensemble;
        let most_waiting = (workforce.threads.get() * WAITING) as u64;
        let work = || loop {
            let block = next.fetch_add(1, Ordering::Relaxed);
            let Some((first, lanes)) = blocks.at(block) else {
                return;
            };
            // Blocks far ahead of the slowest wait, so that few are held in memory.
            while block > taken.load(Ordering::Relaxed) + most_waiting {
                if signals.stop.load(Ordering::Relaxed) {
                    return;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            let record = block::run(ensemble, first, lanes, &signals);
            let is_over = !matches!(record, Ok(Some(_)));
            if sender.clone().send((block, record)).is_err() || is_over {
                return;
            }
        };
        std::thread::scope(|scope| {
            let threads = 0..workforce.threads.get();
            let workers: Vec<_> = threads.map(|_| scope.spawn(work)).collect();
            let mut waiting = BTreeMap::new();
            let (mut at, started) = (0, Instant::now());
            let before = self.wall;
            let mut saved = Instant::now();
            let mut is_stuck = false;
            let outcome = loop {
                if at == blocks.count() {
                    break Ok(RunOutcome::Done);
                }
                if progress.is_interrupted() {
                    break Ok(RunOutcome::Interrupted);
                }
                match receiver.recv_timeout(SHOW_EVERY) {
                    Ok((block, Ok(Some(record)))) => {
                        waiting.insert(block, record);
                        is_stuck = false;
                    }
                    Ok((_, Err(error))) => break Err(error.into()),
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
                    steps: from * steps + signals.steps.load(Ordering::Relaxed),
                    total: members * steps,
                    time: ensemble.time(steps),
                    energy_drift: self.reductions.whole.first().map_or(0.0, |d| d.maximum),
                });
                if result.is_ok() && saved.elapsed() >= CHECKPOINT_EVERY {
                    result = self.checkpoint().and_then(|checkpoint| save(&checkpoint));
                    saved = Instant::now();
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
        record.fold(&mut self.reductions);
        self.store.push(self.ensemble, record)
    }

    /// What a resumed session needs.
    pub fn checkpoint(&mut self) -> Result<Checkpoint, RunError> {
        Ok(Checkpoint {
            fingerprint: self.ensemble.population.fingerprint(),
            members: self.ensemble.population.members(),
            wall_seconds: self.wall.as_secs_f64(),
            stored_bytes: self.store.sync()?,
            reductions: self.reductions.clone(),
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
