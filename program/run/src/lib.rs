//! A composed scene, stepped into a run directory.
//!
//! - [`ensemble`]: many members at once, reduced into such a directory;
//! - [`sweep`]: one run for each of many settings, a table of them;
//! - [`perform`]: a run, an ensemble, a sweep or a part of these, in its directory;
//! - `job`: the frame of all; [`shards`]: parts of ensembles and sweeps for many processes;
//! - [`advice`]: warnings where a scene asks for what it does not use, or not for what it needs;
//! - [`csv`]: tables as CSV;
//! - `ordered`: numbered tasks on several threads;
//! - `columns`: the columns of `samples.csv` and `windows.csv`;
//! - `start`: whether a run can begin at its initial state;
//! - `execute`: [`RunJob`], a run of one trajectory; in memory: [`run_in_memory`]; `ending`: how its manifest ends;
//! - `drive`: a walk, stepped into the tables of a run;
//! - `crossing`: where a run in memory crosses a surface;
//! - `invariants`: deviations of energy and Casimirs at every step, their maxima over windows;
//! - `samples`: recorded states, appended to `samples.csv`;
//! - `appended`: a file that only grows, with a digest;
//! - `states`: recorded states too wide for `samples.csv`;
//! - `snapshots`: fields of long lattices, thinned out for the report;
//! - `room`: memory for what is kept, or its want as an error;
//! - `retraced`: states at any times, from the nearest one that was kept;
//! - `replaced`: a file that is replaced as a whole;
//! - `sealed`: files that are read back to every bit, or refused;
//! - `chaos`: whether a run that records MEGNO is regular or chaotic;
//! - `shadow`: a map's step judged by the energy of its shadow; `shadow_step`: the step that keeps it as well as asked;
//! - `checkpoint`: everything later steps depend on, written atomically;
//! - `watch`: states that the method is judged at, whatever is recorded;
//! - `sampled`: the method judged by a run that has ended, for warnings;
//! - `summary`: `report.html` from what the directory holds;
//! - `level_set`: the way of a state onto a level set of functions;
//! - `round_off`: values of formulas with a bound on their rounding;
//! - `progress`: progress of a run, as a program shows it;
//! - `outcome`, `error`: how a run ends.

pub mod advice;
mod appended;
mod chaos;
mod checkpoint;
mod columns;
mod crossing;
pub mod csv;
mod drive;
mod ending;
pub mod ensemble;
mod error;
mod execute;
mod invariants;
mod job;
mod level_set;
mod ordered;
mod outcome;
mod perform;
mod planes;
mod progress;
mod replaced;
mod retraced;
mod room;
mod round_off;
mod sampled;
mod samples;
mod sealed;
mod seam;
mod shadow;
mod shadow_step;
mod snapshots;
mod start;
mod state_error;
mod states;
mod summary;
pub mod sweep;
#[cfg(test)]
mod tests;
mod watch;

pub use advice::{Advice, AdviceKind, JudgedStates, advise};
pub(crate) use appended::{Appended, Vouched};
pub use chaos::{ChaosVerdict, MotionKind};
pub(crate) use checkpoint::StatisticsFields;
pub use crossing::Crossing;
pub use error::RunError;
pub use execute::{Asked, Recorded, RunJob, run_in_memory};
pub use invariants::InvariantDrift;
pub(crate) use job::{CHECKPOINT, REPORT, plugins};
pub use job::{
    FilesRecord, Kind, Manifest, PROGRAM_VERSION, PluginRecord, RunOptions, ShardRecord,
    default_directory, shards,
};
pub use leafwise_walk::Event;
pub use outcome::{Failure, RunOutcome, RunReport, SolverFields};
pub use perform::perform;
pub use progress::{Progress, Quiet, Status};
pub(crate) use replaced::{confirm, replace};
pub use retraced::{Retrace, Retraced};
pub use room::{NoRoom, with_room};
pub(crate) use sealed::Format;
pub use shadow::ShadowVerdict;
pub use shadow_step::{NoShadowStep, ShadowStep};
pub use state_error::{NoStateError, StateError};
pub(crate) use summary::{file_name, method_lines, short, title};
