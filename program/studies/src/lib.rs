//! Studies with scenes and parts.
//!
//! - [`conformance`]: is one part, built-in or of a plugin, what it declares?
//! - [`verify`]: what every part really does, measured against what it declares.
//! - [`trade`]: cost against accuracy, measured on a scene: `compare` and `tune`.
//! - [`orbit`]: periodic orbits, their multipliers and families; equilibria.
//! - [`reproduce`](mod@reproduce): the paper's figures and numbers, measured.
//! - [`stress`]: the extremes, each with its expected outcome.

pub mod conformance;
pub mod orbit;
pub mod reproduce;
pub mod stress;
pub mod trade;
pub mod verify;
