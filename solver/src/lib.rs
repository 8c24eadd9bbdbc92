//! The step solver: β̂(L(y)) = x for y, and the increment α̂ − β̂ there.
//!
//! It knows code and numbers, and neither systems nor realizations: what is solved comes as
//! [`SourceTarget`], an [`Evaluator`] or a residual.
//!
//! - [`Stepper`], [`Trajectories`]: one thread's steps.
//! - [`NewtonKernel`], [`NewtonStepper`]: Newton's method on compiled kernels, lanes side by side.
//! - [`Iteration`], [`judge`]: corrections of any other solve, and when they end.
//! - [`Branch`]: the solution that belongs to the state.
//! - [`Differential`]: derivatives of a step.
//! - [`error`]: typed failures.

mod anderson;
mod batch;
mod branch;
mod checked;
mod columns;
pub mod compensation;
mod crossing;
mod differential;
mod elimination;
mod equation;
pub mod error;
pub mod evaluator;
mod explicit;
mod extrapolation;
mod hint;
mod iteration;
pub mod judge;
mod lanes;
mod linear;
mod newton;
mod numeric;
mod properties;
mod record;
mod statistics;
mod stepper;

pub use anderson::Anderson;
pub use batch::batch;
pub use branch::Branch;
pub use checked::Checked;
pub use columns::product;
pub use compensation::{Compensated, two_sum};
pub use crossing::{Crossing, looks};
pub use differential::{ByTangents, Differential, Inverse, Solved, by_parameters, one_step};
use differential::{Explicit, in_reverse};
pub use equation::{Correction, SourceTarget};
pub use error::{BuildError, StepError};
pub use evaluator::Evaluator;
pub use explicit::ExplicitMap;
pub use extrapolation::Extrapolation;
pub use hint::Hint;
pub use iteration::{CorrectionMethod, Iteration};
pub use judge::CorrectionSize;
pub use judge::LinearSolve;
pub use lanes::{Lanes, StepReport, Trajectories};
pub use linear::{
    DenseFactors, MANY_EQUATIONS, MOST_EQUATIONS, MOST_VARIABLES, check_equations, check_variables,
    elimination_operations, substitution_operations,
};
use nalgebra::DMatrix;
use nalgebra::linalg::balancing::{balance_parlett_reinsch, unbalance};
pub use newton::{NewtonKernel, NewtonStepper, StartCode, Uncoupled};
pub use numeric::{NumericSolver, Progress, Solve};
pub use properties::{MapProperties, Pieces, Structure};
pub use record::StepRecord;
pub use statistics::SolverStatistics;
pub use stepper::{
    Setting, StepCheck, Stepper, add, add_finite, are_finite, one_by_one, restore_each,
};

/// DΦ = 1 + D((α̂ − β̂)∘L)·D(β̂∘L)⁻¹ from the two tangents at the solution, all row-major d × d.
///
/// Elimination takes place in coordinates x/s with s of powers of two that balance D(β̂∘L). Rows of very different sizes, as of a
/// momentum that has grown a thousandfold, would mix their round-off.
pub(crate) fn tangent_of_map(target: &[f64], change: &[f64], d: usize) -> Option<Vec<f64>> {
    let mut target = DMatrix::from_row_slice(d, d, target);
    let mut change = DMatrix::from_row_slice(d, d, change);
    // Squares beyond the range would never be balanced.
    let has_sizes = target.norm_squared().is_finite();
    let sizes = has_sizes.then(|| balance_parlett_reinsch(&mut target));
    if let Some(sizes) = &sizes {
        unbalance(&mut change, &sizes.map(f64::recip));
    }
    let mut tangent = DMatrix::identity(d, d) + change * target.lu().try_inverse()?;
    if let Some(sizes) = &sizes {
        unbalance(&mut tangent, sizes);
    }
    Some(tangent.transpose().as_slice().to_vec())
}
