//! Why a figure could not be reproduced.

use leafwise_core::{BuildError, StepError};
use leafwise_scene::{Refusal, SceneErrors};

use super::paper::FIGURES;
use crate::verify::ProblemError;

/// Why a figure could not be reproduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// The paper has no figure of this name.
    #[error(
        "the paper has no figure `{name}`; there are 1 to {} or, by name, {}",
        FIGURES.len(),
        FIGURES.map(|figure| figure.id).join(", ")
    )]
    UnknownFigure {
        /// The name.
        name: String,
    },
    /// A system of the library that cannot be set up.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A figure's scene that cannot be read.
    #[error("a figure's scene: {0}")]
    Scene(#[from] SceneErrors),
    /// A figure's scene that cannot be composed.
    #[error("a figure's scene: {0}")]
    Refused(Refusal),
    /// A part that cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A step that fails.
    #[error("figure {figure}, step {step}: {error}")]
    Step {
        /// The figure's number.
        figure: usize,
        /// The step, from 1.
        step: u64,
        /// Why.
        error: StepError,
    },
    /// Errors that decide no order.
    #[error("figure {figure}: too few errors lie above round-off to fit an order")]
    NoOrder {
        /// The figure's number.
        figure: usize,
    },
}
