//! Poisson integrators assembled from symplectic realizations and Lagrangian bisections.
//!
//! - [`core`]: the vocabulary: systems, realizations, dynamic approximations, methods.
//! - [`expression`]: formulas, exact algebra, straight-line kernels.
//! - [`karasev`], [`lie_poisson`], [`so3`] and others: realizations; [`hamilton_jacobi`], [`collective`], [`one_form`], [`splitting`] and others:
//!   dynamics and steppers.
//! - [`systems`]: the problem library.
//! - [`plugins`]: parts of third parties from shared libraries.
//! - [`equilibrium`]: magnetic fields of tokamaks, read from g-files.
//! - [`find`]: brackets of equations of motion, found and proved.
//! - [`learn`]: Poisson maps from pairs of states, by least squares.
//! - [`walk`]: trajectories in memory, watched between steps.
//! - [`scene`]: scene files, composed.
//! - [`run`]: runs, ensembles and sweeps, into directories; [`report`]: their pages.
//! - [`conformance`]: checks that one part, built-in or of a plugin, is as declared.
//! - [`verify`]: every part measured against its declaration.
//! - [`orbit`]: periodic orbits and their multipliers.
//! - [`trade`]: cost against accuracy, measured on a scene.
//! - [`reproduce`](mod@reproduce): the paper's figures and numbers, measured.
//! - [`stress`]: the extremes, each with its expected outcome.
//! - [`prelude`]: types and functions that most programs need.

pub mod prelude;

pub use leafwise_clebsch as clebsch;
pub use leafwise_closed_form as closed_form;
pub use leafwise_collective as collective;
pub use leafwise_composition as composition;
pub use leafwise_constant as constant;
pub use leafwise_core as core;
pub use leafwise_darboux_magnetic as darboux_magnetic;
pub use leafwise_direct_sum as direct_sum;
pub use leafwise_equilibrium as equilibrium;
pub use leafwise_expression as expression;
pub use leafwise_find as find;
pub use leafwise_generating_function as generating_function;
pub use leafwise_hamilton_jacobi as hamilton_jacobi;
pub use leafwise_karasev as karasev;
pub use leafwise_learn as learn;
pub use leafwise_lie_poisson as lie_poisson;
pub use leafwise_log_canonical as log_canonical;
pub use leafwise_logarithms as logarithms;
pub use leafwise_one_form as one_form;
pub use leafwise_plugin_loader as plugins;
pub use leafwise_reference as reference;
pub use leafwise_report as report;
pub use leafwise_run as run;
pub use leafwise_scene as scene;
pub use leafwise_so3 as so3;
pub use leafwise_splitting as splitting;
pub use leafwise_studies::{conformance, orbit, reproduce, stress, trade, verify};
pub use leafwise_systems as systems;
pub use leafwise_walk as walk;

#[cfg(doctest)]
#[doc = include_str!("../../docs/guide/from-rust.md")]
struct FromRust;
