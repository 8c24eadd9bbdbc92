//! One run for each of many settings of a scene's keys, and a table of them.
//!
//! - `settings`: [`Settings`], the values of each by number;
//! - `plan`: [`compose_sweep`], the methods that they need, each composed once;
//! - `row`: the row of a run in the table;
//! - `columns`: [`SweepColumns`], the table's headings;
//! - `session`: settings on threads, their rows in order;
//! - `checkpoint`: all that a resumed sweep needs;
//! - `report`: [`SweepReport`], results of a sweep that has ended; `page`: to look at;
//! - `execute`: [`SweepJob`], all settings or some of them.

mod checkpoint;
mod columns;
mod execute;
mod page;
mod plan;
mod report;
mod row;
mod session;
mod settings;
#[cfg(test)]
mod tests;

pub use columns::SweepColumns;
pub use execute::SweepJob;
pub use plan::{ComposedSweep, compose_sweep};
pub use report::{SweepEnding, SweepReport};
pub use settings::Settings;
