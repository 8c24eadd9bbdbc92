//! What takes in the records of a walk.

use leafwise_core::{BuildError, Walk};

use crate::fault::Ended;

/// Takes in what a [`Watched`](crate::Watched) walk comes to, in the order of the way. `()` takes in nothing.
pub trait Sink {
    /// Why something cannot be taken in.
    type Error: From<BuildError>;

    /// Hears of the states before a step.
    fn begin_step(&mut self, walk: &Walk) {
        let _ = walk;
    }

    /// Hears of the states after a step that a lane has made.
    fn end_step(&mut self, walk: &Walk) {
        let _ = walk;
    }

    /// Takes in the invariants after a step, at `time` in the first lane: invariant i of lane w at `[i*lanes + w]`.
    fn invariants(&mut self, walk: &Walk, time: f64, values: &[f64]) {
        let _ = (walk, time, values);
    }

    /// Takes in the states after a step that some lane goes on from, or that is the last.
    ///
    /// # Errors
    /// [`Sink::Error`].
    fn step(&mut self, walk: &Walk, time: f64) -> Result<(), Self::Error> {
        let _ = (walk, time);
        Ok(())
    }

    /// Takes in the sample of a lane with this number at its time.
    ///
    /// # Errors
    /// [`Sink::Error`].
    fn sample(&mut self, sample: Sample<'_>) -> Result<(), Self::Error> {
        let _ = sample;
        Ok(())
    }

    /// Takes in where a lane crosses the surface of an event.
    ///
    /// # Errors
    /// [`Sink::Error`].
    fn crossing(
        &mut self,
        event: usize,
        lane: usize,
        time: f64,
        state: &[f64],
    ) -> Result<(), Self::Error> {
        let _ = (event, lane, time, state);
        Ok(())
    }

    /// Takes in the end of a lane.
    ///
    /// # Errors
    /// [`Sink::Error`].
    fn ended(&mut self, lane: usize, ended: &Ended) -> Result<(), Self::Error> {
        let _ = (lane, ended);
        Ok(())
    }
}

impl Sink for () {
    type Error = BuildError;
}

/// A state at a time that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// The lane.
    pub lane: usize,
    /// Its number, from 1 on.
    pub number: u64,
    /// Its time.
    pub time: f64,
    /// The state.
    pub state: &'a [f64],
    /// The number of steps that the lane has made, where the state is that after the last one.
    pub steps: Option<u64>,
}
