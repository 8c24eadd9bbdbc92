//! Splitting of long lattices: every piece is a sweep over the sites that it moves.
//!
//! - [`units`]: a Hamiltonian's terms up to translation, and the pieces that repeat along the
//!   lattice.
//! - [`map`](mod@map): Strang's product over such pieces.
//! - `sweeps`: its steps.
//! - `differential`: their differentials.

mod differential;
pub mod map;
mod sweeps;
pub mod units;

pub use map::LatticeSplitting;
pub(crate) use sweeps::Shared;
