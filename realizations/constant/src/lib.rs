//! The exact realization of a constant Poisson tensor.
//!
//! α_ε(x, p) = x − ½ ε Π p, β_ε(x, p) = x + ½ ε Π p, σ(x) = (x, 0), on all of T*M: Karasev's
//! realization, whose curve is a straight line.
//!
//! - [`realization`]: [`ConstantRealization`], its maps as code and as sweeps over a lattice.
//! - [`series`]: α along p(h) in the exact ring, for Hamilton–Jacobi coefficients.

pub mod realization;
pub mod series;

pub use realization::ConstantRealization;
