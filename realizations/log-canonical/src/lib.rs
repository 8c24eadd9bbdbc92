//! The exact realization of a log-canonical Poisson tensor.
//!
//! For {x_i, x_j} = a_ij x_i x_j, every Lotka–Volterra system among them,
//! α_i = x_i e^{−u_i}, β_i = x_i e^{u_i} with u_i = ½ ε Σ_j a_ij x_j p_j, and σ(x) = (x, 0). The
//! chart is not Karasev's: the two agree to first order in ε only.
//!
//! - [`realization`]: [`LogCanonical`], its maps as code and as sweeps over a lattice.
//! - `tensor`: the coefficients a_ij.
//! - [`series`]: α along p(h) in the exact ring, for Hamilton–Jacobi coefficients.

pub mod realization;
pub mod series;
mod tensor;

pub use realization::LogCanonical;
