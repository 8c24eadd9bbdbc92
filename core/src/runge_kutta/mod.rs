//! Implicit Runge–Kutta methods: coefficients and stage equations.
//!
//! - [`tableau`]: nodes, weights and matrices, those of Gauss for any number of stages.
//! - [`smooth_map`]: maps and their Jacobians, as kernels or as numbers.
//! - `jacobian`: Jacobians that are formed when the first one is asked for.
//! - `stage_lanes`: the stage equations of Gauss methods by fixed-point iteration, the stages in the lanes of vectors.
//! - [`stages`]: the stage equations of a partitioned method by Newton's iteration, or without Jacobians,
//!   of several trajectories in lockstep.

mod jacobian;
pub mod smooth_map;
pub(crate) mod stage_lanes;
mod stage_solve;
pub mod stages;
pub mod tableau;

pub use smooth_map::{SmoothMap, SmoothMapEvaluator};
pub use stages::StageSolver;
pub use tableau::{PartitionedTableau, Tableau};
