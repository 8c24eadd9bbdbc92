//! Gauss steps in Clebsch variables are Poisson maps.

mod across;
mod algebras;
mod common;
mod held;
mod representations;
mod rotations;
mod sums;
