//! How lanes end.

use leafwise_core::StepError;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::pace::NoPace;

/// Why a lane cannot go on.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// A step, or a part of one, could not be taken.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A formula, by its text, has no value.
    #[error("`{0}` has no finite value at this state")]
    Undefined(String),
    /// Events, by the text of their surface, follow each other without end within one step, or leave the state on the surface.
    #[error("events at `{0}` follow each other without end: the motion comes to rest there")]
    Accumulates(String),
    /// More events than these, by the text of their surface, act within one step.
    #[error("more than {1} events at `{0}` act within one step")]
    TooMany(String, usize),
    /// The state is outside the domain of the first invariant, the energy.
    #[error("energy has no finite value at this state")]
    Outside,
    /// The initial state has too few directions for the exponents.
    #[error(
        "the initial state has too few directions for the Lyapunov exponents up to the last that is recorded"
    )]
    Leaf,
    /// Steps of a fictitious time do not advance the time as they should.
    #[error(transparent)]
    Pace(#[from] NoPace),
}

/// Why a lane has ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Why {
    /// Every step was made, or the time at the end is reached.
    Done,
    /// The condition began to hold.
    Stopped,
    /// The event with this number came as often as asked for.
    Event(usize),
    /// It cannot go on.
    Failed(Fault),
}

/// Where and why a lane has ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Why.
    pub why: Why,
    /// The steps made; for a [`Fault`], those before the one that could not be taken.
    pub steps: u64,
    /// The time there.
    pub time: f64,
    /// The state there.
    pub state: Vec<f64>,
    /// Whether that lies between two steps.
    pub is_between: bool,
}

/// Where a condition has ended a walk between two steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopPlace {
    /// The steps made.
    pub steps: u64,
    /// The time there.
    pub time: f64,
    /// The state there.
    pub state: Vec<f64>,
}

impl StopPlace {
    /// The place, where a lane has ended so.
    pub(crate) fn of(ended: &Ended) -> Option<Self> {
        let is_it = ended.why == Why::Stopped && ended.is_between;
        is_it.then(|| Self {
            steps: ended.steps,
            time: ended.time,
            state: ended.state.clone(),
        })
    }
}

impl From<StopPlace> for Ended {
    fn from(place: StopPlace) -> Self {
        Self {
            why: Why::Stopped,
            steps: place.steps,
            time: place.time,
            state: place.state,
            is_between: true,
        }
    }
}
