//! Derivatives of trajectories by their initial states and parameters, exact for the map that is stepped.
//!
//! - [`differential`]: [`Differential`], a step with its derivative, in both directions.
//! - `solved`: of steps that solve β̂(L(y)) = x, with solves by foreseen Jacobians in `foreseen`; `explicit`: of explicit ones.
//! - [`trajectory`]: tangents forwards, covectors backwards.
//! - [`growth`]: how fast derivatives grow, and what that leaves of their digits.
//! - `checkpoints`: the states of a run in reverse order, from few that are kept.

mod checkpoints;
pub mod differential;
mod error;
mod explicit;
mod foreseen;
pub mod growth;
mod solved;
pub mod trajectory;

pub use differential::{ByTangents, Differential};
pub use error::GradientError;
pub use explicit::Inverse;
pub(crate) use explicit::{Explicit, in_reverse};
pub use growth::Growth;
pub(crate) use solved::{Solved, by_parameters};
pub use trajectory::{Gradient, Plan, Pushed, Reached, Trajectory, Way};
