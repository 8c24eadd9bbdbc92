//! What tests share: the claims of this package and the property tests of realizations.
//!
//! - [`realizations`]: property tests of an exact realization, ready to be called by the author of a
//!   new one.
//! - [`structure`]: the tensor and the Casimirs under one step.
//! - [`orders`]: a measured order with a tolerance that follows from the points.
//! - [`lattice`]: a long lattice beside the same one written out.
//! - [`systems`]: Poisson systems of the library by id, or from a few formulas.
//! - [`scenes`]: runs composed from scene texts.
//! - [`methods`]: methods of realization and dynamics, runs, values of formulas.
//! - [`gauss`]: an independent integrator of high order, as an oracle.
//! - [`coefficients`]: Karasev's coefficients at a point, exact and compiled.
//! - [`opaque`]: systems that offer numbers only.
//! - [`numbers`]: sizes and distances, componentwise errors, decimal strings of reference data.
//! - [`strategies`]: random states, tensors and systems.
//!
//! It names no realization but Karasev's and depends on no facade, so that every other realization
//! can take its tests from here.

pub mod coefficients;
pub mod gauss;
pub mod lattice;
pub mod methods;
pub mod numbers;
pub mod opaque;
pub mod orders;
pub mod realizations;
pub mod scenes;
pub mod strategies;
pub mod structure;
pub mod systems;

pub use methods::{method, realization};
pub use systems::{Problem, library};
