//! When a checkpoint is due.

use std::time::{Duration, Instant};

use crate::RunError;

/// How often a checkpoint is written, at most.
const EVERY: Duration = Duration::from_secs(2);

/// Largest share of the time that writing checkpoints may take, one part in so many; slow ones are written less often.
const SHARE: u32 = 20;

/// The last checkpoint of a job of many items: when it was written, and how long that took.
pub(crate) struct Due {
    saved: Instant,
    took: Duration,
}

impl Due {
    /// A checkpoint was written just now.
    pub fn new() -> Self {
        Self {
            saved: Instant::now(),
            took: Duration::ZERO,
        }
    }

    /// Writes a checkpoint where the next is due.
    pub fn save(&mut self, write: impl FnOnce() -> Result<(), RunError>) -> Result<(), RunError> {
        if self.saved.elapsed() >= EVERY.max(SHARE * self.took) {
            let begun = Instant::now();
            write()?;
            (self.saved, self.took) = (Instant::now(), begun.elapsed());
        }
        Ok(())
    }
}
