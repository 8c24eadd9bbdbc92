//! Newton's method on compiled kernels, trajectories side by side.
//!
//! - `kernel`: [`NewtonKernel`], the code of an iteration, with and without its Jacobian.
//! - `at_once`: the code of a whole step of one or two iterations.
//! - `convergence`: when a solve is done, and which kernel comes next.
//! - `block`: a fixed number of trajectories, in lanes.
//! - `stepper`: [`NewtonStepper`], any number of them.
//! - `uncoupled`: [`Uncoupled`], equations that have no coordinate in common, each solved by itself.

mod at_once;
mod block;
mod convergence;
mod kernel;
mod start;
mod stepper;
mod uncoupled;

pub use kernel::NewtonKernel;
pub use kernel::StartCode;
pub use stepper::NewtonStepper;
pub use uncoupled::Uncoupled;
