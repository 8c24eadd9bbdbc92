//! Checkpoint of an ensemble: all that a resumed one needs, in one file that is replaced atomically.

use std::ops::Range;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::plan::ComposedEnsemble;
use super::tree::Tree;
use crate::job::Folder;
use crate::{CHECKPOINT, Format, RunError, Vouched};

/// Format of the checkpoint of an ensemble: the name of its content, and its number.
const FORMAT: Format = Format {
    name: b"leafens",
    number: b'A',
};

/// An ensemble between two members. Another field, order or type is another format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Of a file of states.
    pub fingerprint: Option<[u8; 32]>,
    /// Members of the whole ensemble.
    pub members: u64,
    /// Seconds of integration so far.
    pub wall_seconds: f64,
    /// The beginning of the file of last states that holds them.
    pub vouched: Vouched,
    /// The beginning of the file of crossings that holds them, and its rows.
    pub section: Vouched,
    pub crossings: u64,
    /// The members taken in so far.
    pub tree: Tree,
}

impl Checkpoint {
    /// Writes the checkpoint of a directory.
    pub fn write(&self, folder: &Folder) -> Result<(), RunError> {
        FORMAT.write(folder, self)
    }

    /// Reads the checkpoint of a directory, of these members of an ensemble.
    ///
    /// # Errors
    /// [`RunError::Damaged`] for one of others.
    pub fn read_of(
        folder: &Folder,
        ensemble: &ComposedEnsemble,
        members: &Range<u64>,
    ) -> Result<Self, RunError> {
        let checkpoint: Self = FORMAT.read(folder)?;
        let population = &ensemble.population;
        let held = checkpoint.tree.members();
        let is_of_these = held.start == members.start && held.end <= members.end;
        let is_of_this = checkpoint.members == population.members()
            && checkpoint.tree.shape() == ensemble.shape();
        let reason = if checkpoint.fingerprint != population.fingerprint() {
            "the file of states has changed since it was written"
        } else if !is_of_these || !is_of_this {
            "it is of another ensemble"
        } else {
            return Ok(checkpoint);
        };
        Err(RunError::Damaged {
            file: folder.join(CHECKPOINT),
            reason: reason.to_owned(),
        })
    }

    /// The time of integration so far.
    pub fn wall(&self) -> Duration {
        Duration::try_from_secs_f64(self.wall_seconds).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::statistics::{MemberFailure, Shape};

    #[test]
    fn a_checkpoint_reads_back_to_the_same_bits() {
        let shape = Shape {
            times: 2,
            observables: 1,
            windows: 3,
            invariants: 1,
            has_quantiles: true,
            losses: 4,
        };
        let mut tree = Tree::new(shape, 128);
        for member in 128..5000_u64 {
            tree.take(|into| {
                into.losses[3] += 1;
                into.summaries[1].push(1.0 / (1 + member) as f64, member);
                into.windows[2].push(1e-9, 17);
                into.statistics.operations = None;
            });
        }
        tree.take(|into| {
            into.push_failure(MemberFailure {
                member: 5000,
                step: 12,
                time: 0.6,
                message: "the state went nowhere · ∞".to_owned(),
                state: vec![0.1, -0.0],
            });
        });
        let checkpoint = Checkpoint {
            fingerprint: Some([5; 32]),
            members: 10_000,
            wall_seconds: 1.5,
            vouched: Vouched {
                bytes: 99,
                sha256: [3; 32],
            },
            section: Vouched::NOTHING,
            crossings: 12,
            tree,
        };
        let root = tempfile::tempdir().expect("a directory");
        let folder = Folder::of_no_scene(root.path());
        checkpoint.write(&folder).expect("written");
        let back: Checkpoint = FORMAT.read(&folder).expect("a checkpoint");
        assert_eq!(back, checkpoint);
    }
}
