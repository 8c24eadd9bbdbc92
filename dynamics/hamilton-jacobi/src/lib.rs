//! The Hamilton–Jacobi dynamic approximation.
//!
//! L̂_{ε,h} = graph(dŜ_{ε,h}) with Ŝ = Σ_{l odd < m} ε^{l−1} hˡ S_l, the truncated solution of
//! ∂_h S = H∘α_ε(x, dS), S_0 = 0 (paper, section 4.2). The S_l come from the untruncated series of
//! the realization's chart, whatever its order n.
//!
//! - [`coefficients`]: the recursion for S_l, in exact algebra or as code.
//! - `form`: which of the two.
//! - [`numbers`]: h dH for systems of numbers.
//! - [`bisection`]: graph(dŜ) as a Lagrangian bisection.

pub mod bisection;
pub mod coefficients;
mod form;
pub mod numbers;

pub use bisection::{HamiltonJacobi, Hamiltonian};
pub use coefficients::generating_function;
