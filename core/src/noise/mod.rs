//! Noise: steps with parameters that are drawn anew before each.
//!
//! Stratonovich's dx = {H, x} dt + Σ_k σ_k {H_k, x} ∘ dW_k moves along leaves, and its flow is a Poisson map almost
//! surely (J.-M. Bismut, *Mécanique aléatoire*, 1981; J.-A. Lázaro-Camí, J.-P. Ortega, *Stochastic Hamiltonian
//! dynamical systems*, Reports on Mathematical Physics 61 (2008)). Over a step t with increments ΔW_k it is, to first
//! order in the mean, the flow of a Hamiltonian H_w. That is H_w = H + Σ_k w_k σ_k H_k with w_k = ΔW_k/t (G. N.
//! Milstein, Yu. M. Repin, M. V. Tretyakov, *Numerical methods for stochastic systems preserving symplectic structure*,
//! SIAM Journal on Numerical Analysis 40 (2002)). Any map of systems with the parameters w_k serves, and a Poisson map
//! stays one.
//!
//! Of second order in the mean is Φ_{t/2} ∘ exp(ΔW_1 σ_1 X_1) ∘ … ∘ exp(ΔW_K σ_K X_K) ∘ Φ_{t/2}. Here Φ is a
//! self-adjoint map of H alone. Where Φ = χ*_{t/2} ∘ χ_{t/2}, χ_{t/2} stands before and χ*_{t/2} behind. The flows of the
//! channels come forwards or backwards with probability 1/2 (S. Ninomiya, N. Victoir, *Weak approximation of stochastic
//! differential equations and application to derivative pricing*, Applied Mathematical Finance 15 (2008)). Both orders stand
//! in one product, 1 … K … 1, where the flows of one pass have no time.
//!
//! - [`increments`]: what is drawn, and where it enters.
//! - [`split`]: split steps as products of flows.
//! - [`swept`]: the same on lattices, by sweeps over one set of fields.
//! - [`map`](mod@map): step maps that draw.

pub mod increments;
pub mod map;
pub mod split;
pub mod swept;

pub use increments::{Noise, Normals, Seed, SiteNoise, normals_of};
pub use map::NoisyMap;
pub use split::SplitNoise;
pub use swept::SweptNoise;
