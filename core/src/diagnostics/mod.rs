//! Instruments: what a system, a realization or a method really is, measured.
//!
//! - [`consistency`]: are the values of a system of numbers those of one Poisson system?
//! - [`differences`]: derivatives where none are offered, with their error.
//! - [`drift`]: invariants at every step, and their growth.
//! - [`identity`]: is the tensor Poisson, is a Casimir one?
//! - [`order`]: an order with a tolerance derived from the points.
//! - [`realization_error`]: ε Π(α̂) − {α̂, α̂}_ω, and the dual-pair error {α̂_i, β̂_j}_ω.
//! - `same_motion`: does a function move a system as its Hamiltonian does?
//! - `sampled_defect`: the tensor defect of many coordinates, along a few directions.
//! - [`section`]: α̂∘σ = β̂∘σ = id.
//! - [`self_adjointness`]: Φ_{−h}∘Φ_h = id.
//! - [`tensor_defect`]: DΦ Π DΦᵀ − Π∘Φ with the exact tangent map.
//! - [`step_equation`]: the solutions of β̂(L(y)) = x, and how far into the chart they reach.
//! - [`slope`]: fitted orders, points under the round-off plateau dropped.

pub mod consistency;
pub mod differences;
pub mod drift;
pub mod identity;
mod numeric_identity;
mod one_step;
pub mod order;
pub mod realization_error;
mod round_off;
pub(crate) mod same_motion;
mod sampled_defect;
pub mod section;
pub mod self_adjointness;
pub mod slope;
pub mod step_equation;
pub mod tensor_defect;
mod verdict;

pub use consistency::{Inconsistency, find_inconsistency};
pub use drift::{InvariantDrift, casimir_round_off, casimir_sizes, measure_drift};
pub use identity::{check_casimir, check_jacobi};
pub use order::{FittedOrder, fit_order, least_slope};
pub use realization_error::RealizationInstrument;
pub use sampled_defect::{COVECTORS, MOST_MEASURED};
pub use section::section_defect;
pub use self_adjointness::self_adjointness_defect;
pub use slope::{Slope, fit_slope};
pub use step_equation::{StepEquation, StepSolution};
pub use tensor_defect::{Defect, TensorDefect};
pub use verdict::{IdentityCheck, Verdict};
