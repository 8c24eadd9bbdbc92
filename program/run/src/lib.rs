//! A composed scene, stepped into a run directory.
//!
//! - [`ensemble`]: many members at once, reduced into such a directory;
//! - [`sweep`]: one run for each of many settings, a table of them;
//! - [`shards`]: parts of ensembles and sweeps for many processes;
//! - [`advice`]: what a scene asks for and does not use, or needs and does not ask for;
//! - [`csv`]: tables as CSV;
//! - `ordered`: numbered tasks on several threads;
//! - `columns`: the columns of `samples.csv` and `windows.csv`;
//! - `execute`: [`run`], from a composed scene to a complete directory, or in memory: [`run_in_memory`];
//! - `drive`: the step loop, and the states it records between two steps;
//! - `last_step`: states between the last two, by shorter steps;
//! - `events`: where a condition begins to hold, and a section is crossed, between two steps;
//! - `paced`: steps of a fictitious time, states at given times;
//! - `invariants`: energy and Casimirs at every step, their maxima over windows;
//! - `samples`: recorded states, appended to `samples.csv`;
//! - `appended`: a file that only grows, with a digest;
//! - `states`: recorded states too wide for `samples.csv`;
//! - `snapshots`: fields of long lattices, thinned out for the report;
//! - `retraced`: states at any times, from the nearest one that was kept;
//! - `replaced`: a file that is replaced as a whole;
//! - `sealed`: files that are read back to every bit, or refused;
//! - `shadow`: what the energy of a map's shadow says of its step; `shadow_step`: the step that keeps it as well as asked;
//! - `checkpoint`: everything later steps depend on, written atomically;
//! - `manifest`: what was run, with what, and how it ended;
//! - `directory`: start afresh, resume, or refuse;
//! - `difference`: what changed between two scenes;
//! - `sampled`: what the samples tell of a method, for warnings;
//! - `summary`: `report.html` from what the directory holds;
//! - `progress`: what a program shows meanwhile;
//! - `outcome`, `error`: how a run ends.

pub mod advice;
mod appended;
mod checkpoint;
mod columns;
pub mod csv;
mod difference;
mod directory;
mod drive;
pub mod ensemble;
mod error;
mod events;
mod execute;
mod invariants;
mod last_step;
mod manifest;
mod ordered;
mod outcome;
mod paced;
mod progress;
mod replaced;
mod retraced;
mod sampled;
mod samples;
mod sealed;
mod shadow;
mod shadow_step;
pub mod shards;
mod snapshots;
mod states;
mod summary;
pub mod sweep;
#[cfg(test)]
mod tests;
mod time;

pub use advice::{Advice, AdviceKind, advise};
pub(crate) use appended::{Appended, Vouched};
pub(crate) use checkpoint::{FILE as CHECKPOINT, StatisticsFields};
pub use directory::default_directory;
pub(crate) use directory::{
    FAILURES, LOSSES, REPORT, RunDirectory, RunRequest, SCENE, STATISTICS, SWEEP, WINDOWS, stem,
};
pub use error::RunError;
pub use events::{Crossing, Event};
pub use execute::{Asked, Recorded, RunOptions, run, run_in_memory};
pub(crate) use manifest::{Beginning, files, plugins};
pub use manifest::{FilesRecord, Kind, Manifest, PROGRAM_VERSION, PluginRecord, ShardRecord};
pub use outcome::{Failure, InvariantDrift, RunOutcome, RunReport, SolverFields};
pub use progress::{Progress, Quiet, Status};
pub(crate) use replaced::replace;
pub use retraced::{Retrace, Retraced};
pub(crate) use sealed::Format;
pub use shadow::ShadowVerdict;
pub use shadow_step::{NoShadowStep, ShadowStep};
pub(crate) use summary::{file_name, method_lines, short, title};
