//! Errors of periodic orbits.

use std::borrow::Cow;

use leafwise_core::gradient::GradientError;
use thiserror::Error;

/// Why no orbit is found.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OrbitError {
    /// A run that has none.
    #[error("{message}")]
    NotOffered {
        /// Reason.
        message: &'static str,
        /// A remedy.
        help: Cow<'static, str>,
    },
    /// A step fails.
    #[error("the orbit cannot be followed: {0}")]
    Step(#[from] GradientError),
    /// Newton's method ends elsewhere.
    #[error(
        "no orbit closes near here: after {iterations} corrections the ends are {closure:.1e} apart"
    )]
    NotClosed {
        /// Corrections made.
        iterations: usize,
        /// max |Φᴺ(x) − x|.
        closure: f64,
    },
    /// The period falls to 0, after which every point is where it was.
    #[error(
        "no orbit closes near here: the period shrinks to zero, from {first} to {period:.1e} after {iterations} corrections"
    )]
    Shrinks {
        /// Corrections made.
        iterations: usize,
        /// The period at first.
        first: f64,
        /// The period at the end.
        period: f64,
    },
    /// The state rests.
    #[error(
        "no orbit closes near here: after {iterations} corrections the state is an equilibrium or next to one, that moves by {moved:.1e} of its size in a period"
    )]
    Equilibrium {
        /// Corrections made.
        iterations: usize,
        /// max |x_k − x_0| over a turn, in units of the coordinates' sizes.
        moved: f64,
    },
    /// The multipliers of an orbit cannot be told from round-off.
    #[error(
        "an orbit closes to {closure:.1e}, but its multipliers drown in round-off: a turn makes changes {growth:.1e} times as large"
    )]
    Multipliers {
        /// max |Φᴺ(x) − x|.
        closure: f64,
        /// The largest singular value of DΦᴺ − 1.
        growth: f64,
    },
    /// A parameter that is not there.
    #[error("the system has no parameter `{name}`")]
    NoParameter {
        /// Its name.
        name: String,
    },
    /// The energy or a Casimir is another one.
    #[error(
        "no orbit closes near here with the {name} held: of the one that closes it is {off:.1e} away"
    )]
    NotHeld {
        /// The invariant.
        name: String,
        /// How far its value is from the one that was to be held, relative.
        off: f64,
    },
}
