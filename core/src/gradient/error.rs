//! [`GradientError`].

use thiserror::Error;

use super::growth::Growth;
use crate::error::StepError;

/// Why a derivative is not there.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GradientError {
    /// A step failed.
    #[error("step {step} failed: {error}")]
    Step {
        /// Its number.
        step: u64,
        /// Why.
        error: StepError,
    },
    /// A map that offers no derivative by the state.
    #[error(
        "{map} offers no exact derivative of its steps; take hamilton-jacobi over a realization in closed form, \
         splitting, or a composition of one of them"
    )]
    NoTangent {
        /// The map.
        map: String,
    },
    /// A map whose derivatives by parameters are not known.
    #[error(
        "{map} computes numbers whose derivatives by the parameters are not known; take hamilton-jacobi over a \
         realization that is code (karasev with a truncation, lie-poisson, log-canonical, constant), splitting, or a composition of one of \
         them, or ask for the gradient by the initial state alone"
    )]
    NoParameters {
        /// The map.
        map: String,
    },
    /// A map that is not stepped back.
    #[error(
        "{map} is not known to be self-adjoint: its steps back are not an inverse; take checkpoints"
    )]
    NotSelfAdjoint {
        /// The map.
        map: String,
    },
    /// A derivative that is no longer a number.
    #[error("overflow at step {step}: {growth}")]
    Overflow {
        /// The step.
        step: u64,
        /// At least how it grew.
        growth: Growth,
    },
    /// It was told to end.
    #[error("interrupted")]
    Interrupted,
}
