//! Ensembles and sweeps in parts, each by a process of its own.
//!
//! - `shard`: [`Shard`], some members or settings;
//! - `found`: [`Shards`], those in directories, whole or with gaps;
//! - `portion`: [`Portion`], which of them a job makes, and from what.

mod found;
mod portion;
mod shard;

pub(crate) use found::Found;
pub(super) use found::is_same;
pub use found::{MergeError, Missing, Shards};
pub use portion::Portion;
pub use shard::{Shard, ShardError, Whole};
