//! A condition and surfaces in all lanes, and where each lane stands beside them.

use leafwise_core::BuildError;

use super::corners::Corners;
use crate::course::Course;
use crate::events::{Event, Side, Stop};
use crate::functions::FunctionValues;
use crate::turns::Past;

/// The condition that ends a walk, in all lanes.
pub(super) struct StopLanes<'a> {
    pub stop: &'a Stop,
    /// Its difference, then the corners of that.
    pub values: FunctionValues,
    /// Values of the difference after the last steps, for each lane.
    pub pasts: Vec<Past>,
    pub corners: Corners,
}

impl<'a> StopLanes<'a> {
    /// That of a course, if it has one.
    pub fn of(
        course: &'a Course,
        lanes: usize,
        parameters: &[f64],
    ) -> Result<Option<Self>, BuildError> {
        let Some((stop, of)) = &course.stop else {
            return Ok(None);
        };
        Ok(Some(Self {
            stop,
            values: of.values(lanes, parameters)?,
            pasts: vec![Past::default(); lanes],
            corners: Corners::new(of.count(), 1, lanes),
        }))
    }

    /// At the initial states.
    pub fn begin(&mut self, states: &[f64]) {
        let values = self.values.at(states);
        let pasts = self.pasts.iter_mut().zip(values);
        pasts.for_each(|(past, value)| *past = Past::begin(*value));
        self.corners.begin(values);
    }

    /// One lane after a step in which the condition has not ended it, with the difference's value there.
    pub fn go_on(&mut self, lane: usize, steps: u64, value: f64) {
        self.pasts[lane] = self.pasts[lane].then(value);
        self.corners.go_on(lane, steps, self.values.last());
    }
}

/// An event in all lanes.
pub(super) struct EventLanes<'a> {
    pub event: &'a Event,
    /// Left − right, what the event sets, and the corners of the first.
    pub values: FunctionValues,
    /// Where each lane stands beside the surface after the last step.
    pub sides: Vec<Side>,
    /// How often each has crossed it.
    pub counts: Vec<u64>,
    pub corners: Corners,
}

impl<'a> EventLanes<'a> {
    /// Those of a course.
    pub fn of(
        course: &'a Course,
        lanes: usize,
        parameters: &[f64],
    ) -> Result<Vec<Self>, BuildError> {
        let events = course.events.iter().map(|(event, of)| {
            Ok(Self {
                event,
                values: of.values(lanes, parameters)?,
                sides: vec![Side::default(); lanes],
                counts: vec![0; lanes],
                corners: Corners::new(of.count(), event.first_corner(), lanes),
            })
        });
        events.collect()
    }

    /// At the initial states.
    pub fn begin(&mut self, states: &[f64]) {
        let values = self.values.at(states);
        let sides = self.sides.iter_mut().zip(values);
        sides.for_each(|(side, value)| *side = Side::begin(*value));
        self.corners.begin(values);
    }

    /// The side of one lane after a step, the last of so many, in which there is nothing to look for.
    pub fn stays(&self, lane: usize, steps: u64) -> Option<Side> {
        let all = self.values.last();
        match self.corners.may_be_passed(lane, all) {
            true => None,
            false => self.sides[lane].stays(all[lane], steps),
        }
    }

    /// One lane's corners after a step, once its side is known.
    pub fn go_on(&mut self, lane: usize, steps: u64) {
        if self.sides[lane].has_seen(steps) {
            self.corners.go_on(lane, steps, self.values.last());
        }
    }
}
