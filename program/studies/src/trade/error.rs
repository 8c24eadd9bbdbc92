//! Why methods could not be compared on a scene.

use leafwise_core::BuildError;
use leafwise_scene::Refusal;

/// Why methods could not be compared on a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TradeError {
    /// The scene cannot be built.
    #[error("{}", .0.message)]
    Refused(Refusal),
    /// A formula that is watched has no code.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A run that ends where it begins.
    #[error("methods are compared over a time; the scene runs from t = 0 to t = {time}")]
    NoTime {
        /// The end time.
        time: f64,
    },
    /// A scene whose map is a table of many steps.
    #[error(
        "the generating function holds for steps of {length} alone, and methods are compared by steps of many lengths on the \
         flow of H, which a table is not; compare them on the scene whose steps it puts together"
    )]
    OneLength {
        /// The length of its steps.
        length: f64,
    },
    /// A run of more steps than can be tried.
    #[error(
        "t = {time:e} is {steps:.1e} of the scene's steps, too many to try methods on; shorten the \
         time or take a larger step"
    )]
    TooLong {
        /// The end time.
        time: f64,
        /// Over the scene's step.
        steps: f64,
    },
    /// None of the methods asked for fits the scene.
    #[error("no method is left to compare: {}", reasons.join("; "))]
    NoMethods {
        /// Why not.
        reasons: Vec<String>,
    },
    /// A tolerance of Casimirs on a scene that has none.
    #[error(
        "the scene names no Casimir to hold; leave out --casimir, or write `casimirs` under [system]"
    )]
    NoCasimirs,
    /// A method that cannot be read.
    #[error("`{text}` is not a method: {reason}")]
    Method {
        /// Text that was given.
        text: String,
        /// Why not.
        reason: String,
    },
    /// A list of steps that cannot be read.
    #[error("`{text}` is not a list of steps: {reason}")]
    Steps {
        /// Text that was given.
        text: String,
        /// Why not.
        reason: String,
    },
    /// No high-accuracy method reaches the end time.
    #[error(
        "no reference solution: {}; shorten the time or choose another initial state",
        reasons.join("; ")
    )]
    NoReference {
        /// Each method with the reason.
        reasons: Vec<String>,
    },
}

impl From<Refusal> for TradeError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}
