//! Records of a walk: steps, samples, crossings and ends, in the order of the way.

use std::cell::Cell;

use crate::batch::Batch;
use crate::course::Course;
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
    /// The course's indicators of chaos: indicator i of lane w at `[i*lanes + w]`.
    pub indicators: &'a [f64],
}

/// Steps of one lane that are looked at together, as if one by one: each is inside of the energy's domain.
pub struct Steps<'a> {
    /// The number of steps made before the first of these.
    pub before: u64,
    /// How many they are.
    pub count: usize,
    pub(crate) batch: &'a Batch,
    pub(crate) course: &'a Course,
    /// How many have been taken in: where one cannot be, the walk goes back to the last that was.
    pub taken: Cell<usize>,
}

impl Steps<'_> {
    /// The state after a step, counted from 0.
    pub fn at(&self, at: usize) -> At<'_> {
        let steps = self.before + at as u64 + 1;
        At {
            steps,
            // As of every walk whose steps are of the time itself.
            time: steps as f64 * self.course.step() + 0.0,
            state: self.batch.state(at),
            evaluations: self.batch.evaluations[at],
            // They are followed step by step.
            indicators: &[],
        }
    }

    /// One coordinate after each step.
    pub fn coordinate(&self, coordinate: usize) -> &[f64] {
        &self.batch.column(coordinate)[..self.count]
    }

    /// One of the invariants after each step.
    pub fn invariant(&self, invariant: usize) -> &[f64] {
        &self.batch.invariant(invariant)[..self.count]
    }

    /// Whether the invariants are looked at after a step, counted from 0.
    pub fn is_looked_at(&self, at: usize) -> bool {
        self.course.looks_at(self.before + at as u64 + 1)
    }

    /// Whether they are after each.
    pub fn are_all_looked_at(&self) -> bool {
        self.course.invariants_every == 1
    }

    /// Evaluations up to each step.
    pub fn evaluations(&self) -> &[u64] {
        &self.batch.evaluations[..self.count]
    }
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
    /// Many steps of one lane, each made and looked at.
    Steps(&'a Steps<'a>),
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
