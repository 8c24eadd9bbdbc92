//! The looks at surfaces that the last step has crossed.

use std::collections::VecDeque;

use leafwise_core::BuildError;

use super::Watched;
use super::looks::time_of;
use crate::events::{Side, crossings};
use crate::fault::{Ended, Why};
use crate::look::Look;
use crate::step::{Between, StepEnd};

/// Where the last step has crossed the surface of an event.
struct Looked {
    /// The event's number.
    at: usize,
    /// The side after the step.
    after: Side,
    /// Times and states of the crossings that are not taken in.
    left: VecDeque<(f64, Vec<f64>)>,
    /// How many were.
    taken: u64,
}

impl Looked {
    /// The side of a walk that comes no further than what is taken in.
    fn side(&self, now: Side) -> Side {
        match (self.left.is_empty(), self.taken) {
            (true, _) => self.after,
            (false, 0) => now,
            (false, _) => now.with_taken(1),
        }
    }
}

impl Watched<'_> {
    /// Takes in the events of the last step in the order in which they come, up to one that ends the lane.
    pub(super) fn look_for_events<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        if self.events.is_empty() {
            return Ok(());
        }
        for event in &mut self.events {
            event.values.at(self.walk.state());
        }
        for lane in 0..self.walk.lanes() {
            if self.moved[lane] && !self.has_failed(lane) {
                self.look_for_events_of(lane, take)?;
            }
        }
        Ok(())
    }

    pub(super) fn has_failed(&self, lane: usize) -> bool {
        let why = self.ends[lane].as_ref().map(|ended| &ended.why);
        matches!(why, Some(Why::Failed(_)))
    }

    fn look_for_events_of<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        lane: usize,
        take: &mut F,
    ) -> Result<(), E> {
        let steps = self.walk.steps();
        let mut looked: Vec<Looked> = Vec::new();
        for at in 0..self.events.len() {
            let own = &mut self.events[at];
            if own.event.act.is_some() {
                continue;
            }
            let (side, value) = (own.sides[lane], own.values.last()[lane]);
            if let Some(side) = own.stays(lane, steps) {
                own.sides[lane] = side;
                continue;
            }
            let after = StepEnd::of(&self.walk, lane);
            let alone = self.alones.at(lane, &self.start)?;
            let values = &mut alone.events[at];
            let last = &mut alone.last;
            let seen = (side, own.corners.of(lane), value, steps);
            let outcome = crossings(own.event, values, last, &after.state, seen);
            match outcome {
                Ok((after, found)) => {
                    let pace = self.course.pace.as_ref();
                    let place = |between: Between| {
                        let time = time_of(pace, last, steps, &between);
                        (time, between.state)
                    };
                    let before = side.taken();
                    looked.push(Looked {
                        at,
                        after,
                        left: found.into_iter().skip(before).map(place).collect(),
                        taken: 0,
                    });
                }
                Err(fault) => {
                    self.fail(lane, fault, steps);
                    return Ok(());
                }
            }
        }
        let forward = self.course.step();
        let mut order: Vec<(f64, usize)> = (looked.iter().zip(0..))
            .flat_map(|(own, at)| own.left.iter().map(move |(time, _)| (*time, at)))
            .collect();
        order.sort_by(|(one, _), (other, _)| (one * forward).total_cmp(&(other * forward)));
        for (time, which) in order {
            if !self.is_on_the_way(lane, time) {
                break;
            }
            let own = &mut looked[which];
            let Some((time, state)) = own.left.pop_front() else {
                break;
            };
            own.taken += 1;
            let at = own.at;
            self.events[at].sides[lane] = own.side(self.events[at].sides[lane]);
            self.take_crossing(at, lane, (time, state, true), take)?;
        }
        for own in looked {
            if own.taken == 0 {
                let sides = &mut self.events[own.at].sides;
                sides[lane] = own.side(sides[lane]);
            }
        }
        for own in &mut self.events {
            own.go_on(lane, steps);
        }
        Ok(())
    }

    /// Takes in a crossing, and ends the lane where that is the last one asked for.
    pub(super) fn take_crossing<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        at: usize,
        lane: usize,
        (time, state, is_between): (f64, Vec<f64>, bool),
        take: &mut F,
    ) -> Result<(), E> {
        let event = at;
        take(Look::Crossing {
            event,
            lane,
            time,
            state: &state,
        })?;
        let own = &mut self.events[at];
        own.counts[lane] += 1;
        if own.event.last == Some(own.counts[lane]) {
            let ended = Ended {
                why: Why::Event(at),
                steps: self.walk.steps(),
                time,
                state,
                is_between,
            };
            self.end(lane, ended);
        }
        Ok(())
    }

    /// Takes in the events on whose surfaces lanes end.
    ///
    /// # Errors
    /// Those of `take`, and [`BuildError`] where a function has no evaluator.
    pub fn end_on_events<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        for lane in 0..self.walk.lanes() {
            for at in 0..self.events.len() {
                let Some(ended) = self.ends[lane].clone() else {
                    continue;
                };
                if matches!(ended.why, Why::Failed(_)) {
                    continue;
                }
                let value = self.alones.at(lane, &self.start)?.events[at].at(&ended.state)[0];
                let own = &self.events[at];
                let section = &own.event.section;
                if own.sides[lane].ends_there(section, value, ended.steps) {
                    let place = (ended.time, ended.state, ended.is_between);
                    self.take_crossing(at, lane, place, take)?;
                }
            }
        }
        Ok(())
    }
}
