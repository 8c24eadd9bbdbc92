//! Checkpoint of a sweep: all that a resumed one needs, in one file that is replaced atomically.

use std::ops::Range;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::job::Folder;
use crate::{CHECKPOINT, Format, RunError, Vouched};

/// Format of the checkpoint of a sweep: the name of its content, and its number.
const FORMAT: Format = Format {
    name: b"leafswp",
    number: b'2',
};

/// A sweep between two settings. Another field, order or type is another format.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Settings of the whole sweep.
    pub settings: u64,
    /// Those that have rows.
    pub first: u64,
    pub next: u64,
    /// How many of them have failed.
    pub failed: u64,
    /// Bits of the seconds of integration so far.
    pub wall_seconds: u64,
    /// The beginning of the table that holds them.
    pub vouched: Vouched,
}

impl Checkpoint {
    /// Writes the checkpoint of a directory.
    pub fn write(&self, folder: &Folder) -> Result<(), RunError> {
        FORMAT.write(folder, self)
    }

    /// The time of integration so far.
    pub fn wall(&self) -> Duration {
        Duration::try_from_secs_f64(f64::from_bits(self.wall_seconds)).unwrap_or_default()
    }

    /// Reads the checkpoint of a directory, of these settings of a sweep.
    ///
    /// # Errors
    /// [`RunError::Damaged`] for one of others.
    pub fn read(folder: &Folder, settings: u64, items: &Range<u64>) -> Result<Self, RunError> {
        let checkpoint: Self = FORMAT.read(folder)?;
        let is_there = (items.start..=items.end).contains(&checkpoint.next);
        let is_of_these = checkpoint.first == items.start && is_there;
        if checkpoint.settings != settings || !is_of_these {
            let (file, reason) = (folder.join(CHECKPOINT), "it is of another sweep".to_owned());
            return Err(RunError::Damaged { file, reason });
        }
        Ok(checkpoint)
    }
}
