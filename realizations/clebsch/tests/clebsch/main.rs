//! Gauss steps in Clebsch variables are Poisson maps.

use leafwise_logarithms as _;

mod across;
mod algebras;
mod common;
mod representations;
mod rotations;
mod sums;
