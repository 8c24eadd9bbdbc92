//! The exact realization of a magnetic bracket with a given vector potential.
//!
//! For positions x_i and momenta p_i with {x_i, x_j} = 0, {x_i, p_j} = s_i δ_ij, s_i = ±1, and
//! {p_i, p_j} = B_ij(x), a potential A with B_ij = s_j ∂_j A_i − s_i ∂_i A_j (for the paper's
//! s = −1 the curl ∂_i A_j − ∂_j A_i) makes P = p − A(x) Darboux coordinates:
//! {x_i, P_j} = s_i δ_ij, {P_i, P_j} = 0. The constant realization there is carried back to the
//! original coordinates.
//!
//! - [`chart`]: positions, momenta and the potential, verified in exact algebra.
//! - [`realization`]: [`DarbouxMagnetic`], its maps as code.
//! - [`series`]: α along p(h) in the exact ring, for Hamilton–Jacobi coefficients.

pub mod chart;
pub mod realization;
pub mod series;

pub use chart::MagneticChart;
pub use realization::DarbouxMagnetic;
