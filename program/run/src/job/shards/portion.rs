//! Items that a job makes, and where they come from.

use std::ops::Range;
use std::path::Path;

use super::found::{Found, MergeError, Shards};
use super::shard::{Shard, Whole};
use crate::job::manifest::{Kind, ShardRecord};

/// Items of a whole that a job makes: all of them or those of a shard, computed or joined from shards.
#[derive(Clone, Debug, Default)]
pub struct Portion<'a> {
    shard: Option<Shard>,
    shards: Option<&'a Shards>,
}

impl<'a> Portion<'a> {
    /// Those of a shard, or all, computed. An unfinished shard goes on, and a finished one is told of again.
    pub fn computed(shard: Option<&Shard>) -> Self {
        Self {
            shard: shard.cloned(),
            shards: None,
        }
    }

    /// All, joined to the bytes that one process writes.
    ///
    /// # Errors
    /// [`MergeError`] for items that are missing or there twice.
    pub fn merged(shards: &'a Shards) -> Result<Self, MergeError> {
        shards.check_whole()?;
        Ok(Self {
            shard: None,
            shards: Some(shards),
        })
    }

    /// Those of shards that follow one another, joined into a larger one. Shards of shards are merged to the same bytes.
    ///
    /// # Errors
    /// As [`merged`](Self::merged), of the items between the first and the last.
    pub fn joined(shards: &'a Shards) -> Result<Self, MergeError> {
        Ok(Self {
            shard: Some(shards.together()?),
            shards: Some(shards),
        })
    }

    /// The shard that they are of, where they are not all.
    pub fn shard(&self) -> Option<&Shard> {
        self.shard.as_ref()
    }

    /// The kind of a job that makes them.
    pub fn kind(&self, whole: Whole) -> Kind {
        match (whole, &self.shard) {
            (Whole::Members, None) => Kind::Ensemble,
            (Whole::Members, Some(_)) => Kind::Shard,
            (Whole::Settings, None) => Kind::Sweep,
            (Whole::Settings, Some(_)) => Kind::SweepShard,
        }
    }

    /// Their numbers, of so many in the whole.
    pub(crate) fn items(&self, count: u64) -> Range<u64> {
        self.shard.as_ref().map_or(0..count, Shard::items)
    }

    /// Which they are, for the manifest of a shard.
    pub(crate) fn record(&self) -> Option<ShardRecord> {
        self.shard.as_ref().map(Shard::record)
    }

    /// The directories that they come from.
    pub(crate) fn sources(&self) -> Vec<&Path> {
        self.shards.map_or_else(Vec::new, Shards::directories)
    }

    /// The shards that they come from and that hold any of them, in their order.
    pub(crate) fn shards(&self) -> impl Iterator<Item = &Found> {
        let done = self.shards.into_iter().flat_map(Shards::done);
        done.filter(|shard| !shard.items().is_empty())
    }
}
