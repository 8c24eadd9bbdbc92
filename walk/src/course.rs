//! Course of a walk: how far it goes, and the samples, events and invariants looked for on the way.

use crate::events::{Event, Stop};
use crate::functions::StateFunctions;
use crate::indicators::Indicators;
use crate::pace::Pace;
use crate::times::SampleTimes;

/// The way of a walk as a value: how far, when states are recorded, what is watched between steps. Functions are compiled once for
/// all walks of one course.
#[derive(Clone)]
pub struct Course {
    /// ε.
    pub epsilon: f64,
    /// h.
    pub h: f64,
    /// Steps at most.
    pub steps: u64,
    /// The time at the end, where that stands in place of a number of steps.
    pub until: Option<f64>,
    /// When states are recorded.
    pub samples: SampleTimes,
    /// dt/dτ, where steps are of a fictitious time τ.
    pub pace: Option<Pace>,
    /// The condition that ends a lane, and its difference.
    pub stop: Option<(Stop, StateFunctions)>,
    /// Surfaces that lanes cross, and left − right.
    pub events: Vec<(Event, StateFunctions)>,
    /// The energy, H + e where there is a pace, then each Casimir.
    pub invariants: StateFunctions,
    /// Steps between two looks at the invariants.
    pub invariants_every: u64,
    /// Indicators of chaos that are followed, if any.
    pub indicators: Option<Indicators>,
}

impl Course {
    /// ε h, the time of a step; of a fictitious time where there is a pace.
    pub fn step(&self) -> f64 {
        self.epsilon * self.h
    }

    /// Whether the invariants are looked at after so many steps.
    pub fn looks_at(&self, steps: u64) -> bool {
        let is_last = self.pace.is_none() && steps == self.steps;
        is_last || steps.is_multiple_of(self.invariants_every)
    }

    /// The time at a state after so many steps.
    pub fn time(&self, steps: u64, state: &[f64]) -> f64 {
        match &self.pace {
            Some(pace) => pace.time_at(state),
            // Of no step backwards in time −0 is 0.
            None => steps as f64 * self.step() + 0.0,
        }
    }

    /// Whether `time` comes before `other` on the way.
    pub fn is_before(&self, time: f64, other: f64) -> bool {
        (other - time) * self.step() > 0.0
    }

    /// Whether states between steps may be asked for.
    pub fn looks_between(&self) -> bool {
        self.pace.is_some()
            || self.stop.is_some()
            || !self.events.is_empty()
            || !self.samples.are_steps()
    }
}
