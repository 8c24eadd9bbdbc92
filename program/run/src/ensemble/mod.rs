//! Many initial states or parameter sets at once: lanes side by side on several threads.
//!
//! - `plan`: [`compose_ensemble`], a scene's system and method with its members;
//! - `population`: [`Population`], the members' initial states and parameters by number;
//! - `leaf`: the way of drawn states onto a leaf;
//! - `states`: [`Members`] that are given, by a file too;
//! - `clock`: when they are looked at; `begun`, `block`: members side by side; `member_records`, `record`: their
//!   records;
//! - `drive`: blocks on threads, taken in by number, so that no result depends on either;
//! - `section`: the crossings in one file;
//! - `statistics`, `quantiles`, `losses`: reductions over members; `tree`: their order;
//! - `report`: [`EnsembleReport`], results of an ensemble that has ended;
//! - `checkpoint`, `store`, `tables`, `ending`, `page`: files of the run directory;
//! - `execute`: [`EnsembleJob`], all of it, or a [`Shard`](crate::shards::Shard) of it.

mod advice;
mod begun;
mod block;
mod checkpoint;
mod clock;
mod drive;
mod ending;
mod execute;
mod leaf;
mod losses;
mod member;
mod member_records;
mod page;
mod plan;
mod population;
mod quantiles;
mod record;
mod report;
mod section;
mod states;
mod statistics;
mod store;
mod tables;
#[cfg(test)]
mod tests;
mod tree;

pub use advice::advise_ensemble;
pub use drive::Workforce;
pub use ending::EnsembleEnding;
pub use execute::EnsembleJob;
pub use losses::Loss;
pub use member::{MemberError, member_scene};
pub use plan::{ComposedEnsemble, compose_ensemble, compose_members};
pub use population::{NoMember, Population};
pub use quantiles::Quantile;
pub use report::EnsembleReport;
pub use states::Members;
pub use statistics::{Deviation, MemberFailure, Reductions, Summary};
