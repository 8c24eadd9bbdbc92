//! Poisson maps learned from pairs of states (x, x'), x' = Φ(x) one step later, over a known tensor.
//!
//! A map of a realization has x' − x = (α̂ − β̂)(y, p) with p = dŜ(y), where −ε Π(y) p is its leading part: linear in the
//! coefficients of Ŝ once y is known. [`learn`](fn@learn) solves for these by least squares and for y by iteration. Whatever the pairs are,
//! the learned map is one of a generating function: Poisson as exactly as the realization is.
//!
//! - `pairs`: the data.
//! - `basis`: functions that Ŝ is a sum of.
//! - `geometry`: the ends of a realization and its tensor, as numbers.
//! - `squares`: linear least squares.
//! - `fit`: coefficients and points y in turn.
//! - `validation`: the degree by pairs that are held out.
//! - `motion`: the learned map itself, and H from it.
//! - `learned`: what was learned, how well, and where it may be used.

mod basis;
mod error;
mod fit;
mod geometry;
mod learn;
mod learned;
mod motion;
mod pairs;
mod squares;
mod validation;

pub use basis::{Basis, BasisAxis, FunctionFamily};
pub use error::LearnError;
pub use learn::{LearnOptions, learn};
pub use learned::{LearnAdvice, Learned, LearnedFunction};
pub use pairs::StatePairs;
