//! Instruments: what a system, a realization or a method really is, measured.
//!
//! - [`identity`]: is the tensor Poisson, is a Casimir one?
//! - [`realization_error`]: ε Π(α̂) − {α̂, α̂}_ω, and the dual-pair error {α̂_i, β̂_j}_ω.
//! - [`tensor_defect`]: DΦ Π DΦᵀ − Π∘Φ with the exact tangent map.
//! - [`slope`]: fitted orders, points under the round-off plateau dropped.

pub mod identity;
pub mod realization_error;
pub mod slope;
pub mod tensor_defect;

pub use identity::{IdentityCheck, Verdict, check_casimir, check_jacobi};
pub use realization_error::RealizationInstrument;
pub use slope::{Slope, fit_slope};
pub use tensor_defect::TensorDefect;
