//! Symmetric compositions of self-adjoint step maps, and of a map and its adjoint.
//!
//! The composition Ψ_h = Φ_{γ_s h} ∘ … ∘ Φ_{γ_1 h} with γ_i = γ_{s+1−i} and Σγ_i = 1 is self-adjoint when Φ is. It is
//! a Poisson map when Φ is, and has the order that the γ_i were solved for (Hairer, Lubich, Wanner, *Geometric
//! Numerical Integration*, section V.3).
//!
//! With α_i = α_{2s+1−i} the composition χ*_{α_{2s} h} ∘ χ_{α_{2s−1} h} ∘ … ∘ χ_{α_1 h} is self-adjoint whatever χ is.
//! This leaves more freedom for smaller errors where a step comes apart as χ*_{h/2} ∘ χ_{h/2}.
//!
//! - [`coefficients`]: the γ_i or α_i of each scheme, with their sources.
//! - [`scheme`]: a scheme: its order, its coefficients, what it declares.
//! - [`composed`]: the composition as a step map.
//! - `schemes`: the parts `triple-jump`, `suzuki-4`, `yoshida-6`, `kahan-li-6`, `kahan-li-8`,
//!   `suzuki-umeno-8`, `kahan-li-10`, `sofroniou-spaletta-10`, `blanes-moan-4`, `blanes-moan-6`;
//!   for two pieces of a kind `nystrom-4`, `nystrom-6`, `nystrom-6-long`, `perturbed-8-2`, `perturbed-10-4`,
//!   `perturbed-8-6-4`, `perturbed-10-6-4`.

pub mod coefficients;
pub mod composed;
pub mod scheme;
mod schemes;

pub use composed::Composed;
pub use scheme::Scheme;
