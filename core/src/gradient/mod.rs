//! Derivatives of trajectories by their initial states and parameters, exact for the map that is stepped.
//!
//! - [`trajectory`]: tangents forwards, covectors backwards.
//! - [`growth`]: how fast derivatives grow, and what that leaves of their digits.
//! - [`times`]: states between the steps with their tangents.
//! - `checkpoints`: the states of a run in reverse order, from few that are kept.

mod checkpoints;
mod error;
pub mod growth;
pub mod times;
pub mod trajectory;

pub use error::GradientError;
pub use growth::Growth;
pub use trajectory::{Gradient, Plan, Pushed, Reached, Trajectory, Way};
