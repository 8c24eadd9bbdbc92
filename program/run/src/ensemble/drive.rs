//! Blocks of members on several threads, taken in by number.

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::block::{self, Signals};
use super::checkpoint::Checkpoint;
use super::plan::ComposedEnsemble;
use super::record::Record;
use super::section::SectionStore;
use super::store::FinalStore;
use super::tree::Tree;
use crate::ordered::{Turn, in_order};
use crate::{Progress, RunError, RunOutcome, Status};

/// How often a checkpoint is written.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(2);

/// Largest share of the time that writing checkpoints may take, one part in so many; slow ones are written less often.
const SHARE: u32 = 20;

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
        let blocks = blocks(
            from,
            members,
            workforce,
            self.ensemble.population.dimension(),
        );
        let signals = Signals::default();
        let (ensemble, directory) = (self.ensemble, self.directory);
        let (started, before) = (Instant::now(), self.wall);
        let (mut saved, mut took) = (Instant::now(), Duration::ZERO);
        let turn = |turn: Turn<Record>| {
            match turn {
                Turn::Take(mut record) => self.take(&mut record)?,
                Turn::Look => {
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
                    if saved.elapsed() >= CHECKPOINT_EVERY.max(SHARE * took) {
                        let begun = Instant::now();
                        let checkpoint = self.checkpoint()?;
                        save(&checkpoint)?;
                        (saved, took) = (Instant::now(), begun.elapsed());
                    }
                }
            }
            Ok(!progress.is_interrupted())
        };
        let tasks = (blocks.count(), workforce.threads);
        let (threads, outcome) = in_order(
            tasks,
            &signals.stop,
            |tools, block| match blocks.at(block) {
                Some(block) => block::run(tools, (ensemble, directory), block, &signals),
                None => Ok(None),
            },
            turn,
        );
        self.threads = threads;
        outcome
    }

    /// Takes a block in.
    fn take(&mut self, record: &mut Record) -> Result<(), RunError> {
        record.fold(self.ensemble, &mut self.tree);
        self.section.push(&mut record.crossings)?;
        self.store.push(self.ensemble, record)
    }

    /// Checkpoint of the session: all that a resumed one needs.
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

/// Coordinates of the members of a block, of which fewer go side by side the longer they are.
const COORDINATES: usize = 1 << 16;

fn blocks(from: u64, members: u64, workforce: Workforce, dimension: usize) -> Blocks {
    let threads = workforce.threads.get() as u64;
    // Few members: smaller blocks, so that every thread has some.
    let share = (members - from).div_ceil(2 * threads).max(1);
    Blocks {
        from,
        members,
        lanes: share
            .min(workforce.lanes.get() as u64)
            .min((COORDINATES / dimension.max(1)).max(1) as u64),
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
