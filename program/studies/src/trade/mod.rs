//! The trade between speed and accuracy, measured on a scene.
//!
//! A *candidate* is a method that fits the scene. Its *setting* is the number of steps to the end time, or the
//! tolerance of a method that chooses its own steps. A *trial* is one run. It has a cost in counted operations
//! ([`SolverStatistics::operations`]) and a largest drift of every invariant. Its error is the largest distance from a
//! reference solution at its steps, or the distance at the end.
//!
//! - [`compare`]: every method over a grid of settings, with the fronts that no other point beats;
//! - [`Tuner`]: the cheapest method and step that hold what is asked;
//! - [`Reference`]: the motion by two methods of high accuracy, with an estimate of its error;
//! - [`Horizon`]: where the end cannot be known, how long the motion can, and why no longer;
//! - [`comparison_page`], [`comparison_figures`]: a comparison as a page, its figures as files;
//! - `candidate`, `catalogue`, `parse`, `grid`, `norm`, `arrival`, `curve`, `trial`, `measured`, `plateau`,
//!   `front`: the pieces;
//! - `tolerances`, `track`, `search`, `stage`: those of the tuner.
//!
//! [`SolverStatistics::operations`]: leafwise_core::SolverStatistics::operations

mod arrival;
mod candidate;
mod catalogue;
mod compare;
mod curve;
mod error;
mod front;
mod grid;
mod horizon;
mod measured;
mod norm;
mod page;
mod parse;
mod plateau;
mod reference;
mod search;
mod stage;
mod tolerances;
mod track;
mod trial;
mod tune;

pub use candidate::{Bench, Candidate, Knob, Setting};
pub use catalogue::{Entry, catalogue};
pub use compare::{CompareOptions, ComparedMethod, Comparison, LEAST_BUDGET, Point, compare};
pub use error::TradeError;
pub use front::pareto_front;
pub use grid::Grid;
pub use horizon::{Horizon, Known};
pub use measured::{Cost, Front, Measured};
pub use norm::distance;
pub use page::{comparison_figures, comparison_page};
pub use parse::parse_method;
pub use reference::{Judged, Reference};
pub use stage::Stage;
pub use tolerances::Tolerances;
pub use trial::{Trial, TrialFailure, Wall, run_trial, tensor_defect, time_run};
pub use tune::{
    Limit, MOST_OPERATIONS, Predicted, Reached, Recommendation, RunnerUp, TuneOptions, Tuner,
    Tuning,
};
