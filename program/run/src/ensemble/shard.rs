//! Some members of an ensemble, for one of many processes.

use std::ops::Range;

use thiserror::Error;

use super::tree::LEAF;
use crate::ShardRecord;

/// Members of an ensemble from a multiple of 64 to another, or to the last one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    members: Range<u64>,
    ensemble: u64,
    place: Option<[u64; 2]>,
}

/// Members that are no shard.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ShardError {
    /// There is no shard of that number.
    #[error("there is no shard {number} of {of}: shards are counted from 1 to {of}")]
    Place {
        /// Which was asked for.
        number: u64,
        /// How many there are.
        of: u64,
    },
    /// The range is not one of whole leaves of the ensemble.
    #[error(
        "the members {from} to {to} are no shard of {ensemble} members: both bounds are multiples of {LEAF}, the second one may be \
         {ensemble}"
    )]
    Bounds {
        /// The first.
        from: u64,
        /// The one behind the last.
        to: u64,
        /// The members of the ensemble.
        ensemble: u64,
    },
}

impl Shard {
    /// Shard `number`, counted from 1, of `of` that are as large as one another to 64 members; where there are more shards than
    /// 64 go into the ensemble, some have none.
    ///
    /// # Errors
    /// [`ShardError::Place`].
    pub fn of(number: u64, of: u64, ensemble: u64) -> Result<Self, ShardError> {
        if number == 0 || number > of {
            return Err(ShardError::Place { number, of });
        }
        let leaves = u128::from(ensemble.div_ceil(LEAF));
        let bound = |shards: u64| {
            // Below the number of leaves.
            let leaf = (leaves * u128::from(shards) / u128::from(of)) as u64;
            leaf.saturating_mul(LEAF).min(ensemble)
        };
        // An empty shard behind the last whole leaf begins at a multiple of 64 as well.
        let first = bound(number - 1) / LEAF * LEAF;
        let end = bound(number).max(first);
        Ok(Self {
            members: first..end,
            ensemble,
            place: Some([number, of]),
        })
    }

    /// These members.
    ///
    /// # Errors
    /// [`ShardError::Bounds`].
    pub fn between(members: Range<u64>, ensemble: u64) -> Result<Self, ShardError> {
        let is_bound = |at: u64| at.is_multiple_of(LEAF) || at == ensemble;
        let is_shard = members.start.is_multiple_of(LEAF)
            && members.start < members.end
            && members.end <= ensemble
            && is_bound(members.end);
        if !is_shard {
            return Err(ShardError::Bounds {
                from: members.start,
                to: members.end,
                ensemble,
            });
        }
        Ok(Self {
            members,
            ensemble,
            place: None,
        })
    }

    /// Its members.
    pub fn members(&self) -> Range<u64> {
        self.members.clone()
    }

    /// A name for its directory, which sorts as the shards do.
    pub fn name(&self) -> String {
        match self.place {
            Some([number, of]) => {
                let digits = of.to_string().len();
                format!("shard-{number:0digits$}-of-{of}")
            }
            None => format!("members-{}-to-{}", self.members.start, self.members.end - 1),
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        let Range { start, end } = self.members;
        let members = match end - start {
            0 => "no members".to_owned(),
            _ => format!("members {start} to {}", end - 1),
        };
        match self.place {
            Some([number, of]) => format!("shard {number} of {of}, {members}"),
            None => members,
        }
    }

    pub(super) fn record(&self) -> ShardRecord {
        ShardRecord {
            members: [self.members.start, self.members.end],
            ensemble: self.ensemble,
            place: self.place,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LEAF, Shard, ShardError};

    #[test]
    fn shards_cover_the_members_each_once() {
        for (ensemble, of) in [
            (1, 1),
            (63, 4),
            (64, 3),
            (65, 2),
            (1000, 7),
            (1_000_000, 1000),
            (100, 1000),
            (u64::MAX, 3),
        ] {
            let mut next = 0;
            for number in 1..=of {
                let shard = Shard::of(number, of, ensemble).expect("a shard");
                let members = shard.members();
                if !members.is_empty() {
                    assert_eq!(members.start, next, "{shard:?}");
                    assert!(members.start.is_multiple_of(LEAF));
                    next = members.end;
                }
            }
            assert_eq!(next, ensemble, "{ensemble} in {of}");
        }
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        for (number, of) in [(0, 4), (5, 4), (1, 0)] {
            assert_eq!(
                Shard::of(number, of, 100),
                Err(ShardError::Place { number, of })
            );
        }
        assert!(Shard::between(64..100, 100).is_ok());
        assert!(Shard::between(0..64, 100).is_ok());
        for members in [0..63, 1..64, 64..64, 0..128, 64..99] {
            assert!(Shard::between(members, 100).is_err());
        }
    }
}
