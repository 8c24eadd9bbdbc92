//! What a walk comes to.

use leafwise_core::Walk;

use crate::fault::Ended;

/// A record of a [`Watched`](crate::Watched) walk, handed over in the order of the way.
pub enum Look<'a> {
    /// The states before a step.
    Before(&'a Walk),
    /// The states after a step that some lane has made.
    After(&'a Walk),
    /// The invariants after a step: invariant i of lane w at `[i*lanes + w]`.
    Invariants {
        /// The states there.
        walk: &'a Walk,
        /// The time of the first lane.
        time: f64,
        /// Their values.
        values: &'a [f64],
    },
    /// The states after a step from which some lane goes on, or which is the last.
    Step {
        /// The states.
        walk: &'a Walk,
        /// The time of the first lane.
        time: f64,
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

/// Takes looks in, until it fails.
pub type Take<'t, E> = &'t mut dyn FnMut(Look<'_>) -> Result<(), E>;
