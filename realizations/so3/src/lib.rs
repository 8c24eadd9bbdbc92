//! Exact symplectic realizations of so(3)*: Πp = x × p, {x1,x2} = −x3 cyclic.
//!
//! All are T*SO(3) ∋ (R, m) with α = m, β = Rᵀm, σ(x) = (1, x), seen through different coordinates.
//! In a cotangent chart about σ, x·dp = ⟨α, vee(dR Rᵀ)⟩ (J. E. Marsden, T. S. Ratiu, *Introduction
//! to Mechanics and Symmetry*, chapters 13 and 15):
//!
//! - [`exponential`]: R = exp \[εp\]×, which is Karasev's realization summed; ε‖p‖ < 2π: the part
//!   `so3-exponential`.
//! - [`cayley`]: R = (1 − ½\[εp\]×)⁻¹(1 + ½\[εp\]×), rational and defined for every p: the part
//!   `so3-cayley`.
//! - [`chart`]: [`Chart`], one of the two.
//! - [`group`]: [`So3Group`], the part `so3-group`: points are unit quaternions with momenta.
//! - [`tensor`]: systems that fit, and the constant factor of their tensor.
//! - [`functions`]: functions of a squared angle, accurate from 0 to the wall.
//! - [`vector`]: cross and scalar products over any algebra.

pub mod cayley;
pub mod chart;
pub mod exponential;
pub mod functions;
pub mod group;
mod source;
pub mod tensor;
pub mod vector;

pub use cayley::Cayley;
pub use chart::Chart;
pub use exponential::So3Exponential;
pub use group::So3Group;
