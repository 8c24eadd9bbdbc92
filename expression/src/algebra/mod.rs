//! Exact algebra: a differential ring of Laurent polynomials with adjoined generators.

mod arithmetic;
mod derivative;
mod division;
mod formula;
mod generator;
mod inverse;
mod monomial;
mod packed;
mod polynomial;
mod relations;
mod rewriting;
mod ring;
mod seams;
#[cfg(test)]
mod tests;

pub use division::{quotient, square_root};
pub use generator::{Atom, Generator};
pub use monomial::{Monomial, Symbol};
pub use polynomial::{Coefficient, CoefficientRing, Polynomial, Terms};
pub use relations::{Elimination, Solutions, relations};
pub use ring::Ring;
