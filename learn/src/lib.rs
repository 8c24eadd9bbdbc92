//! Poisson maps learned from pairs of states (x, x'), x' = Φ(x) one step later, over a known tensor.
//!
//! A map of a realization has x' − x = (α̂ − β̂)(y, p) with p = dŜ(y). Its leading part −ε Π(y) p is linear in the coefficients of Ŝ once y is known.
//! [`learn`](fn@learn) solves for these by least squares, and for y by iteration. Whatever the pairs are, the learned map has a generating function: it is
//! Poisson as exactly as the realization is.
//!
//! - `pairs`: the data.
//! - `basis`: functions that Ŝ is a sum of.
//! - `geometry`: the ends of a realization and its tensor, as numbers.
//! - `squares`: linear least squares.
//! - `fit`: coefficients and points y in turn.
//! - `validation`: the degree by pairs that are held out.
//! - `motion`: the learned map itself, and H from it.
//! - `tabulate`: many steps as one map.
//! - `learned`: results, their errors, and where they may be used.

mod basis;
mod error;
mod fit;
mod geometry;
mod learn;
mod learned;
mod motion;
mod pairs;
mod squares;
mod tabulate;
mod validation;

pub use basis::{Basis, BasisAxis, BasisDegree, FunctionFamily};
pub use error::LearnError;
pub use learn::{LearnOptions, learn};
pub use learned::{LearnAdvice, Learned, LearnedFunction};
pub use pairs::StatePairs;
pub use tabulate::{ManySteps, Region, Tabulated, tabulate};
