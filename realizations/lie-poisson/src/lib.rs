//! The exact realization of a linear Poisson tensor, whatever the Lie algebra.
//!
//! For Π_ij(x) = Σ_k c_ij^k x_k let Z = ε A(p), A(p) y = Π(y) p, the coadjoint map of p. Then
//! α = Z/(e^Z − 1) x, β = e^Z α = α(x, −p), σ(x) = (x, 0): Karasev's realization in closed form,
//! the exponential chart of T*G for a Lie group G of the algebra.
//!
//! - [`structure`]: the structure constants, exact and as numbers.
//! - [`even_part`]: (Z/2) coth(Z/2) by partial fractions of its continued fraction.
//! - [`worker`]: α, β and their tangents as numbers.
//! - [`realization`]: [`LiePoisson`], the realization data.
//! - `register`: the part `lie-poisson`.

pub mod even_part;
pub mod realization;
mod register;
pub mod structure;
pub mod worker;

pub use realization::LiePoisson;
