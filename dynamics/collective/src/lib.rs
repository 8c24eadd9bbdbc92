//! Collective integrators as a dynamic approximation.
//!
//! L̂_{ε,h} = Σ_h(σ(M)), Σ_h a symplectic integrator of order m for the collective Hamiltonian
//! K = H∘α̂_ε on (S, ω) (paper, section "Collective integrators", Algorithm 2). The paper takes
//! x_{k+1} = α̂(Σ_h(σ(x_k))), which is Poisson to the order of Σ_h only. Solving β̂(Σ_h(σ(y))) =
//! x_k for y as well makes the map exactly Poisson over an exact realization.
//!
//! - [`hamiltonian`]: the vector field of K in a symplectic chart, compiled.
//! - [`numbers`]: the same over a realization that computes numbers.
//! - [`stormer_verlet`], [`implicit_midpoint`], [`gauss`]: the integrators Σ_h, one a file.
//! - [`bisection`]: y ↦ Σ_h(σ(y)) as a Lagrangian bisection.
//! - [`collective`]: [`Collective`], the dynamic approximation.

pub mod bisection;
pub mod collective;
pub mod gauss;
pub mod hamiltonian;
pub mod implicit_midpoint;
pub mod numbers;
pub mod stormer_verlet;

pub use collective::{Collective, SymplecticIntegrator};
