//! The host's own maps, handed to plugins in the tables that plugins hand to the host.
//!
//! - `points`: reading the points of a call and writing its results;
//! - `system`: Π, H and their derivatives;
//! - `realization`: α̂, β̂, σ and their derivatives.

mod points;
mod realization;
mod system;

pub(crate) use realization::{HostRealization, RealizationToLend};
pub(crate) use system::HostSystem;
