//! Fields in Boozer coordinates: surfaces of stellarators and tokamaks, their field strength, guiding centres in them.
//!
//! B = ∇ψ × ∇θ + ι ∇ζ × ∇ψ = G ∇ζ + I ∇θ, with the toroidal flux 2πψ (A. Boozer, Phys. Fluids 24, 1999, 1981). Its vector
//! potential is A = ψ ∇θ − χ ∇ζ with χ′ = ι. A guiding centre of charge q and mass m has ρ = u/B and H = ρ²B²/2 + μB. Its
//! one-form is
//!
//! ((q/m) ψ + ρ I) dθ + (ρ G − (q/m) χ) dζ.
//!
//! An angle θ has no value on the axis. The coordinates are x = √s cos θ and y = √s sin θ with s = ψ/ψ_edge. There
//! s dθ = x dy − y dx is regular. So is the field strength, whose harmonics cos mθ fall as s^(m/2).
//!
//! - Module `data`: the numbers.
//! - Module `surfaces`: numbers between surfaces and beyond the last one.
//! - Module `strength`: |B| anywhere, by harmonics of the angles on each surface.
//! - Module `field`: the field, where its tables leave the numbers, and starts of particles.
//! - Module `scene`: the scene, and the files of its tables.

mod data;
mod field;
mod scene;
mod strength;
mod surfaces;

pub use data::BoozerData;
pub use field::{Boozer, Departure};
pub use scene::written_in_boozer;
