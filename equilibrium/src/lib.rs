//! Equilibria of tokamaks and stellarators as Poisson systems: g-files of EFIT, fields in Boozer coordinates, guiding centres in them.
//!
//! B = ∇ψ × ∇φ + F ∇φ, with the flux ψ(R, Z) in Wb/rad and F(ψ) = R B_φ in T·m. Its vector potential has the components
//! A_R = 0, A_Z = −∫F/R dR, A_φ = ψ along dR, dZ, dφ. A guiding centre of charge q and mass m moves by the one-form
//! (q/m) A + u b and H = u²/2 + μ B (R. Littlejohn, J. Plasma Phys. 29, 111, 1983). What is tabulated is A, so that the
//! field has no divergence and the bracket is Poisson on every grid.
//!
//! - [`Boozer`]: a field in Boozer coordinates;
//! - [`Geqdsk`]: the numbers of a g-file.
//! - [`Equilibrium`]: field, axis, surfaces and safety factor.
//! - [`Ions`]: kinds, energies and starts of particles.
//! - [`written`], [`written_in_boozer`]: the scene, and the files of its tables.

mod boozer;
mod equilibrium;
mod error;
mod geqdsk;
mod ions;
mod roughness;
mod surface;
mod tokens;
mod written;

pub use boozer::{Boozer, BoozerData, Departure, written_in_boozer};
pub use equilibrium::{Equilibrium, Smeared};
pub use error::EquilibriumError;
pub use geqdsk::Geqdsk;
pub use ions::{Ions, Species, Start};
pub use written::{Written, written};
