//! How a part broke the contract when it was tried.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The first thing wrong with a part that was tried at a few points.
#[derive(Clone, Debug, PartialEq, Error, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SmokeFailure {
    /// A function failed where it may not.
    #[error("{function}: {message}")]
    Call {
        /// The function.
        function: String,
        /// Its status and what it says.
        message: String,
    },
    /// A result that is no finite number, or none at all.
    #[error("{function}: non-finite output at point {point} coordinate {coordinate}")]
    NotFinite {
        /// The function.
        function: String,
        /// The point of the batch.
        point: usize,
        /// The coordinate of the result.
        coordinate: usize,
    },
    /// Two calls, two answers.
    #[error(
        "{function}: two calls at the same points gave different answers; a map depends on its \
         instance and its point alone"
    )]
    NotRepeatable {
        /// The function.
        function: String,
    },
    /// A point's result depends on the batch around it or on the layout.
    #[error(
        "{function}: point {point} alone, or in another layout, gave another answer than in a batch"
    )]
    BatchDiffers {
        /// The function.
        function: String,
        /// The point.
        point: usize,
    },
    /// It wrote where nothing of it belongs.
    #[error("{function}: canary: it wrote {where_to}")]
    Overwritten {
        /// The function.
        function: String,
        /// Where.
        where_to: String,
    },
    /// A result that was not written.
    #[error(
        "{function}: LW_OK, and the output at point {point} coordinate {coordinate} is not written"
    )]
    Unwritten {
        /// The function.
        function: String,
        /// The point of the batch.
        point: usize,
        /// The coordinate of the result.
        coordinate: usize,
    },
    /// Another instance changed what this one answers.
    #[error(
        "{function}: an instance gave another answer after another instance was made and called; \
         keep its data in the instance, not in a `static`, SAVE or COMMON"
    )]
    DependsOnOthers {
        /// The function.
        function: String,
    },
    /// Instances on several threads disturb each other.
    #[error(
        "{function}: instances called on several threads at once gave other answers than one alone; \
         put scratch space in the instance or on the stack, not in a `static`, SAVE or COMMON"
    )]
    NotParallel {
        /// The function.
        function: String,
    },
    /// An equation of the contract that does not hold.
    #[error("{identity} violated: {found:?} in place of {expected:?}")]
    Identity {
        /// The equation.
        identity: String,
        /// Its left side.
        found: Vec<f64>,
        /// Its right side.
        expected: Vec<f64>,
    },
    /// An instance of an impossible shape.
    #[error("{problem}")]
    Shape {
        /// The impossible shape, in words.
        problem: String,
    },
    /// The control word of the thread was changed.
    #[error("{problem}")]
    FloatingPoint {
        /// The change, and when it was made.
        problem: String,
    },
}
