//! A part of an ensemble or of a sweep, for one of many processes.

use std::ops::Range;

use thiserror::Error;

use crate::job::manifest::ShardRecord;

/// Whole that shards are parts of: an ensemble or a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whole {
    /// The members of an ensemble.
    Members,
    /// The settings of a sweep.
    Settings,
}

impl Whole {
    /// A shard begins and ends with a multiple of this: members are joined by a tree whose leaves are whole.
    pub fn unit(self) -> u64 {
        match self {
            Self::Members => 64,
            Self::Settings => 1,
        }
    }

    /// Word for the items of the whole: `members` or `settings`.
    pub fn items(self) -> &'static str {
        match self {
            Self::Members => "members",
            Self::Settings => "settings",
        }
    }

    /// The whole in words.
    pub fn word(self) -> &'static str {
        match self {
            Self::Members => "ensemble",
            Self::Settings => "sweep",
        }
    }
}

/// Members of an ensemble from a multiple of 64 to another, or to the last one; or settings of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shard {
    whole: Whole,
    items: Range<u64>,
    count: u64,
    place: Option<[u64; 2]>,
}

/// A part that is no shard.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ShardError {
    /// There is no shard of that number.
    #[error("there is no shard {number} of {of}: {}", match of {
        0 => "there is at least one".to_owned(),
        of => format!("shards are counted from 1 to {of}"),
    })]
    Place {
        /// Which was asked for.
        number: u64,
        /// How many there are.
        of: u64,
    },
    /// The range is not one of whole leaves of the ensemble.
    #[error(
        "the {} {from} to {to} are not a shard of {count}: both bounds are multiples of {}, the second one may be {count}",
        whole.items(), whole.unit()
    )]
    Bounds {
        /// Of what.
        whole: Whole,
        /// The first.
        from: u64,
        /// The one behind the last.
        to: u64,
        /// How many there are.
        count: u64,
    },
}

impl Shard {
    /// Shard `number`, counted from 1, of `of` that are as large as one another to a unit. Where there are more shards
    /// than units go into the whole, some have none.
    ///
    /// # Errors
    /// [`ShardError::Place`].
    pub fn of(whole: Whole, number: u64, of: u64, count: u64) -> Result<Self, ShardError> {
        if number == 0 || number > of {
            return Err(ShardError::Place { number, of });
        }
        let unit = whole.unit();
        let units = u128::from(count.div_ceil(unit));
        let bound = |shards: u64| {
            // Below the number of units.
            let units = (units * u128::from(shards) / u128::from(of)) as u64;
            units.saturating_mul(unit).min(count)
        };
        // An empty shard behind the last whole unit begins at a multiple as well.
        let first = bound(number - 1) / unit * unit;
        let end = bound(number).max(first);
        Ok(Self {
            whole,
            items: first..end,
            count,
            place: Some([number, of]),
        })
    }

    /// These members or settings.
    ///
    /// # Errors
    /// [`ShardError::Bounds`].
    pub fn between(whole: Whole, items: Range<u64>, count: u64) -> Result<Self, ShardError> {
        let unit = whole.unit();
        let is_bound = |at: u64| at.is_multiple_of(unit) || at == count;
        let is_shard = items.start.is_multiple_of(unit)
            && items.start < items.end
            && items.end <= count
            && is_bound(items.end);
        if !is_shard {
            return Err(ShardError::Bounds {
                whole,
                from: items.start,
                to: items.end,
                count,
            });
        }
        Ok(Self {
            whole,
            items,
            count,
            place: None,
        })
    }

    /// Shard of the items that other shards hold together.
    pub(super) fn joined(whole: Whole, items: Range<u64>, count: u64) -> Self {
        Self {
            whole,
            items,
            count,
            place: None,
        }
    }

    /// Its members or settings.
    pub fn items(&self) -> Range<u64> {
        self.items.clone()
    }

    /// A name for its directory, which sorts as the shards do.
    pub fn name(&self) -> String {
        match self.place {
            Some([number, of]) => {
                let digits = of.to_string().len();
                format!("shard-{number:0digits$}-of-{of}")
            }
            None => format!(
                "{}-{}-to-{}",
                self.whole.items(),
                self.items.start,
                self.items.end - 1
            ),
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        let Range { start, end } = self.items;
        let items = self.whole.items();
        let items = match end - start {
            0 => format!("no {items}"),
            _ => format!("{items} {start} to {}", end - 1),
        };
        match self.place {
            Some([number, of]) => format!("shard {number} of {of}, {items}"),
            None => items,
        }
    }

    pub(crate) fn record(&self) -> ShardRecord {
        ShardRecord {
            members: [self.items.start, self.items.end],
            ensemble: self.count,
            place: self.place,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Shard, ShardError, Whole};

    #[test]
    fn shards_cover_the_members_each_once() {
        let sizes = [
            (1, 1),
            (63, 4),
            (64, 3),
            (65, 2),
            (1000, 7),
            (1_000_000, 1000),
            (100, 1000),
            (u64::MAX, 3),
        ];
        let both = [Whole::Members, Whole::Settings];
        for (whole, (ensemble, of)) in both
            .iter()
            .flat_map(|whole| sizes.map(|size| (*whole, size)))
        {
            let mut next = 0;
            for number in 1..=of {
                let shard = Shard::of(whole, number, of, ensemble).expect("a shard");
                let members = shard.items();
                if !members.is_empty() {
                    assert_eq!(members.start, next, "{shard:?}");
                    assert!(members.start.is_multiple_of(whole.unit()));
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
                Shard::of(Whole::Members, number, of, 100),
                Err(ShardError::Place { number, of })
            );
        }
        assert!(Shard::between(Whole::Members, 64..100, 100).is_ok());
        assert!(Shard::between(Whole::Members, 0..64, 100).is_ok());
        for members in [0..63, 1..64, 64..64, 0..128, 64..99] {
            assert!(Shard::between(Whole::Members, members, 100).is_err());
        }
    }
}
