//! Clebsch variables of so(3)*: Hopf's map of ℂ² as coordinates with a constant tensor.
//!
//! With z = (q₀, q₁, p₀, p₁) and {q_a, p_b} = −λ δ_ab the functions
//!
//! x₁ = ½(q₀q₁ + p₀p₁), x₂ = ½(q₀p₁ − p₀q₁), x₃ = ¼(q₀² + p₀² − q₁² − p₁²)
//!
//! have the brackets {x₁, x₂} = −λx₃ of so(3)*, cyclically, and 4|x| = |z|². Their fibres are the orbits of the turns
//! q + ip ↦ e^{iφ}(q + ip), which a Gauss method commutes with: its step descends to a Poisson map of x
//! (R. McLachlan, K. Modin, O. Verdier, Collective symplectic integrators, Nonlinearity 27 (2014)).
//!
//! - [`hopf`]: Hopf's map, its inverse and its slopes.
//! - [`so3`]: [`So3Clebsch`], the part `clebsch`.

pub mod hopf;
pub mod so3;

pub use so3::So3Clebsch;
