//! Session of an ensemble: blocks of members on several threads, taken in by number.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::block::{self, Signals};
use super::checkpoint::Checkpoint;
use super::plan::ComposedEnsemble;
use super::record::Record;
use super::report::EnsembleReport;
use super::section::SectionStore;
use super::store::FinalStore;
use super::tree::Tree;
use crate::job::shards::Found;
use crate::job::{Due, Folder, Held, JobSession};
use crate::ordered::{Turn, in_order};
use crate::{Progress, RunError, RunOutcome, Status};

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
pub struct Session<'a> {
    ensemble: &'a ComposedEnsemble,
    workforce: Workforce,
    tree: Tree,
    store: FinalStore,
    section: SectionStore,
    /// Where it is written.
    folder: Folder,
    wall: Duration,
    /// Threads that the members were stepped on.
    threads: usize,
    /// The member behind the last.
    end: u64,
    /// The member that an earlier session had come to.
    resumed_at: Option<u64>,
}

impl<'a> Session<'a> {
    /// No member yet, of these.
    pub fn begin(
        ensemble: &'a ComposedEnsemble,
        folder: &Folder,
        members: Range<u64>,
        workforce: Workforce,
    ) -> Result<Self, RunError> {
        Ok(Self {
            ensemble,
            workforce,
            tree: Tree::new(ensemble.shape(), members.start),
            store: FinalStore::create(ensemble, folder, members.end - members.start)?,
            section: SectionStore::create(ensemble, folder)?,
            folder: folder.clone(),
            wall: Duration::ZERO,
            threads: 0,
            end: members.end,
            resumed_at: None,
        })
    }

    /// These members as the checkpoint of a directory has them; no file is changed before [`go_on`](JobSession::go_on).
    pub fn resume(
        ensemble: &'a ComposedEnsemble,
        folder: &Folder,
        members: &Range<u64>,
        workforce: Workforce,
    ) -> Result<Self, RunError> {
        let checkpoint = Checkpoint::read_of(folder, ensemble, members)?;
        let (section, crossings) = (&checkpoint.section, checkpoint.crossings);
        Ok(Self {
            ensemble,
            workforce,
            store: FinalStore::resume(ensemble, folder, &checkpoint.vouched)?,
            section: SectionStore::resume(ensemble, folder, section, crossings)?,
            folder: folder.clone(),
            wall: checkpoint.wall(),
            threads: 0,
            end: members.end,
            resumed_at: Some(checkpoint.tree.next()),
            tree: checkpoint.tree,
        })
    }

    /// Takes in the members of a shard, which follow.
    pub(crate) fn append(&mut self, shard: &Found) -> Result<(), RunError> {
        let (members, path) = (shard.items(), &shard.directory);
        let checkpoint = Checkpoint::read_of(&self.folder.beside(path), self.ensemble, &members)?;
        if checkpoint.tree.members() != members {
            return Err(shard.holds_fewer());
        }
        self.wall += checkpoint.wall();
        self.tree.append(checkpoint.tree);
        self.store
            .append(self.ensemble, path, &checkpoint.vouched)?;
        let (section, crossings) = (&checkpoint.section, checkpoint.crossings);
        self.section.append(self.ensemble, path, section, crossings)
    }

    /// Report of the ensemble as the session leaves it, still without advice.
    pub fn report(&self, outcome: RunOutcome, is_repeated: bool) -> EnsembleReport {
        let crossings = self.ensemble.run.plan.events.section.as_ref();
        EnsembleReport {
            outcome,
            wall_seconds: self.wall.as_secs_f64(),
            reductions: self.tree.total(),
            crossings: crossings.map(|_| self.section.count),
            resumed_at: self.resumed_at.filter(|_| !is_repeated),
            is_repeated,
            threads: self.threads,
            advice: Vec::new(),
            directory: self.folder.to_path_buf(),
        }
    }

    /// Whether all members are there.
    pub fn is_at_end(&self) -> bool {
        self.tree.next() == self.end
    }

    /// Takes a block in.
    fn take(&mut self, record: &mut Record) -> Result<(), RunError> {
        record.fold(self.ensemble, &mut self.tree);
        self.section.push(&mut record.crossings)?;
        self.store.push(self.ensemble, record)
    }

    /// Writes a checkpoint: all that a resumed session needs.
    pub fn save(&mut self) -> Result<(), RunError> {
        let checkpoint = Checkpoint {
            fingerprint: self.ensemble.population.fingerprint(),
            members: self.ensemble.population.members(),
            wall_seconds: self.wall.as_secs_f64(),
            vouched: self.store.sync()?,
            section: self.section.sync()?,
            crossings: self.section.count,
            tree: self.tree.clone(),
        };
        checkpoint.write(&self.folder)
    }
}

impl JobSession for Session<'_> {
    fn repeat(&mut self, held: &Held) -> Result<Option<RunOutcome>, RunError> {
        if !held.is_done || !self.is_at_end() {
            return Ok(None);
        }
        self.store.confirm_end()?;
        self.section.confirm_end()?;
        Ok(Some(RunOutcome::Done))
    }

    fn go_on(&mut self, _: &Held) -> Result<(), RunError> {
        self.store.go_on()?;
        self.section.go_on(&self.folder)
    }

    /// Steps all members that are left, or as many as go before an interruption, with checkpoints.
    fn drive(&mut self, progress: &mut dyn Progress) -> Result<RunOutcome, RunError> {
        let (begun, members) = (self.tree.members().start, self.end);
        // Where steps are not counted, members are.
        let steps = self.ensemble.steps().unwrap_or(1);
        let from = self.tree.next();
        let dimension = self.ensemble.population.dimension();
        let workforce = self.workforce;
        let blocks = blocks(from, members, workforce, dimension);
        let signals = Signals::default();
        let (ensemble, directory) = (self.ensemble, self.folder.to_path_buf());
        let (started, before) = (Instant::now(), self.wall);
        let mut due = Due::new();
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
                    due.save(|| self.save())?;
                }
            }
            Ok(!progress.is_interrupted())
        };
        let tasks = (blocks.count(), workforce.threads);
        let (threads, outcome) = in_order(
            tasks,
            &signals.stop,
            |tools, block| match blocks.at(block) {
                Some(block) => block::run(tools, (ensemble, &directory), block, &signals),
                None => Ok(None),
            },
            turn,
        );
        self.threads = threads;
        let outcome = outcome?;
        self.save()?;
        Ok(outcome)
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
