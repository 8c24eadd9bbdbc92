//! What a walk comes to.

use crate::fault::Ended;

/// The states between two steps.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// The number of steps made.
    pub steps: u64,
    /// The time of the first lane.
    pub time: f64,
    /// The states: coordinate j of lane w at `[j*lanes + w]`.
    pub state: &'a [f64],
    /// Evaluations so far, those of the solver's statistics.
    pub evaluations: u64,
}

/// A record of a [`Watched`](crate::Watched) walk, handed over in the order of the way.
pub enum Look<'a> {
    /// A step that some lane has made, before anything is said of it.
    Made(At<'a>),
    /// A step that was looked at.
    Step {
        /// The states after it.
        at: At<'a>,
        /// The invariants there, where they were looked at and some lane is inside of the energy's domain: invariant i of lane w
        /// at `[i*lanes + w]`.
        invariants: Option<&'a [f64]>,
        /// Whether some lane goes on, or this is the last step.
        goes_on: bool,
    },
    /// A state at a time that is asked for.
    Sample {
        /// The lane.
        lane: usize,
        /// Its number, from 1 on.
        number: u64,
        /// Its time.
        time: f64,
        /// The state.
        state: &'a [f64],
        /// The number of steps that the lane has made, where the state is that after the last one.
        steps: Option<u64>,
    },
    /// Where a lane crosses the surface of an event.
    Crossing {
        /// The event's number.
        event: usize,
        /// The lane.
        lane: usize,
        /// The time.
        time: f64,
        /// The state.
        state: &'a [f64],
    },
    /// The end of a lane.
    Ended {
        /// The lane.
        lane: usize,
        /// Where and why.
        ended: &'a Ended,
    },
}
