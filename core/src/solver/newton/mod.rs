//! Newton's method on compiled kernels, trajectories side by side.
//!
//! - `kernel`: [`NewtonKernel`], the code of an iteration, with and without its Jacobian.
//! - `convergence`: when a solve is done, and which kernel comes next.
//! - `block`: a fixed number of trajectories, in lanes.
//! - `stepper`: [`NewtonStepper`], any number of them.

mod block;
mod convergence;
mod kernel;
mod start;
mod stepper;

pub use kernel::NewtonKernel;
pub use stepper::NewtonStepper;
