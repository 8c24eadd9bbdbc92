//! What the claim files share.
//!
//! - [`systems`]: Poisson systems of the library by id, or from a few formulas.
//! - [`methods`]: realizations, dynamic approximations and methods by part name; runs.
//! - [`coefficients`]: Karasev's coefficients at a point, exact and compiled.
//! - [`numbers`]: decimal strings of reference data, componentwise errors.
//! - [`opaque`]: systems that offer numbers only.
//! - [`orders`]: a measured order with a tolerance that follows from the points.
//! - [`gauss`]: an independent integrator of high order, as an oracle.
//! - [`strategies`]: random states, tensors and systems.

pub mod coefficients;
pub mod gauss;
pub mod methods;
pub mod numbers;
pub mod opaque;
pub mod orders;
pub mod strategies;
pub mod systems;

pub use methods::{method, realization};
pub use systems::{Problem, library};
