//! What a run records, and where it ends, between two steps.

use super::Session;
use crate::error::RunError;
use crate::events::{Crossing, Lost};
use crate::last_step::Between;
use crate::outcome::Failure;
use leafwise_scene::compose::is_same_time;

impl Session<'_> {
    /// Looks whether the run has stopped in the last step, and where; why that is not known.
    pub(super) fn find_stop(&mut self) -> Option<Failure> {
        let (Some(stop), Some(last)) = (&mut self.stop, &mut self.last) else {
            return None;
        };
        let found = match stop.end(last, self.integrator.state()) {
            Ok(found) => found?,
            Err(lost) => return Some(self.failure_of(lost)),
        };
        let time = self.time_of(&found);
        if self.is_on_the_way(time) {
            self.is_stopped = true;
            self.end = Some((time, found.state));
        }
        None
    }

    /// Takes in the events of the last step in the order in which they come, up to one that ends the run; why one is not known.
    pub(super) fn find_events(&mut self) -> Option<Failure> {
        if self.events.is_empty() {
            return None;
        }
        let (mut found, steps) = (Vec::new(), self.integrator.steps());
        for at in 0..self.events.len() {
            let last = self.last.as_mut()?;
            match self.events[at].crossing(last, self.integrator.state(), steps) {
                Ok((side, None)) => self.events[at].go_on(side),
                Ok((side, Some(between))) => {
                    found.push((self.time_of(&between), at, between.state, side));
                }
                Err(lost) => return Some(self.failure_of(lost)),
            }
        }
        let forward = self.run.plan.epsilon * self.run.plan.h;
        found.sort_by(|(one, ..), (other, ..)| (one * forward).total_cmp(&(other * forward)));
        for (time, at, state, side) in found {
            if !self.is_on_the_way(time) {
                break;
            }
            self.events[at].go_on(side);
            if self.take_event(at, time, &state) {
                self.end = Some((time, state));
            }
        }
        None
    }

    /// Takes in the events on whose surfaces the run ends.
    pub(super) fn find_events_at_end(&mut self) {
        if self.events.is_empty() {
            return;
        }
        let (steps, (time, state)) = (self.integrator.steps(), self.last_state());
        for at in 0..self.events.len() {
            if self.events[at].ends_there(&state, steps) {
                self.take_event(at, time, &state);
            }
        }
    }

    /// The time and the state at which the run ends.
    fn last_state(&self) -> (f64, Vec<f64>) {
        let present = || (self.time(), self.integrator.state().to_vec());
        self.end.clone().unwrap_or_else(present)
    }

    /// Takes in a crossing of an event's surface; whether the run ends there.
    fn take_event(&mut self, at: usize, time: f64, state: &[f64]) -> bool {
        let state = self.run.own(state).to_vec();
        let is_last = self.events[at].take(Crossing { time, state });
        if is_last && self.ended_by.is_none() {
            (self.is_stopped, self.ended_by) = (true, Some(at));
        }
        is_last
    }

    /// Records where the last step crosses the section; why that is not known.
    pub(super) fn record_crossing(&mut self) -> Result<Option<Failure>, RunError> {
        let (Some(section), Some(last)) = (&mut self.section, &mut self.last) else {
            return Ok(None);
        };
        let (state, steps) = (self.integrator.state(), self.integrator.steps());
        let (side, found) = match section.crossing(last, state, steps) {
            Ok(crossing) => crossing,
            Err(lost) => return Ok(Some(self.failure_of(lost))),
        };
        if let Some(found) = found {
            let time = self.time_of(&found);
            if !self.is_on_the_way(time) {
                return Ok(None);
            }
            self.push_crossing(time, &found.state)?;
        }
        if let Some(section) = &mut self.section {
            section.side = side;
        }
        Ok(None)
    }

    /// Records the state at the end where that lies on the section.
    pub(super) fn record_end_on_section(&mut self) -> Result<(), RunError> {
        let (steps, (time, state)) = (self.integrator.steps(), self.last_state());
        let section = self.section.as_mut();
        match section.is_some_and(|section| section.ends_there(&state, steps)) {
            true => self.push_crossing(time, &state),
            false => Ok(()),
        }
    }

    fn push_crossing(&mut self, time: f64, state: &[f64]) -> Result<(), RunError> {
        self.fill_row(state);
        match &mut self.crossings {
            Some(crossings) => crossings.push(time, &self.shown, &self.row),
            None => Ok(()),
        }
    }

    /// The time of a state within the last step.
    fn time_of(&self, between: &Between) -> f64 {
        match (&self.paced, &self.last) {
            (None, Some(last)) => last.time(self.integrator.steps(), between.part),
            (Some(paced), _) => paced.time_at(&between.state),
            (None, None) => self.time(),
        }
    }

    /// Whether a time comes before the run's end, where that lies at a time.
    fn is_on_the_way(&self, time: f64) -> bool {
        let forward = self.run.plan.epsilon * self.run.plan.h;
        let stopped = self.end.as_ref().map(|(end, _)| *end);
        let end = stopped.or(self.run.plan.until);
        end.is_none_or(|end| (end - time) * forward >= 0.0)
    }

    fn failure_of(&self, lost: Lost<'_>) -> Failure {
        match lost {
            Lost::Step(error) => self.failure_of_step(&error),
            Lost::Undefined(text) => Failure::of_observable(
                &format!("`{text}`"),
                self.integrator.steps(),
                self.time(),
                self.run.own(self.integrator.state()),
            ),
        }
    }

    /// Records the states at the given times that the last step has passed.
    pub(super) fn record_times(&mut self) -> Result<Option<Failure>, RunError> {
        while let Some(time) = self.passed_time() {
            let (steps, present) = (self.integrator.steps(), self.time());
            let Some(last) = &mut self.last else {
                return Ok(None);
            };
            let state = match &self.paced {
                Some(paced) => paced.state_at(last, (&self.integrator).into(), time),
                None if is_same_time(present, time) => {
                    self.record_present(time)?;
                    continue;
                }
                None => last.state_at(steps, time),
            };
            match state {
                Ok(state) => self.record_state(time, &state)?,
                Err(error) => return Ok(Some(self.failure_of_step(&error))),
            }
        }
        Ok(None)
    }

    /// The time of the next sample, where the last step has passed it.
    fn passed_time(&self) -> Option<f64> {
        let plan = &self.run.plan;
        let forward = plan.epsilon * plan.h;
        let time = plan.samples.time(self.samples.count(), forward)?;
        // The end itself is recorded as the end.
        let ends = [self.end.as_ref().map(|(end, _)| *end), plan.until];
        let is_end = |end: f64| plan.samples.is_end(time, end, plan.until);
        let is_ahead = |end: f64| (end - time) * forward > 0.0 && !is_end(end);
        if !ends.into_iter().flatten().all(is_ahead) {
            return None;
        }
        let present = self.time();
        let is_met = self.paced.is_none() && is_same_time(present, time);
        (is_met || (present - time) * forward >= 0.0).then_some(time)
    }

    /// The state at the time at which the run ends; why there is none.
    pub(super) fn reach_end(&mut self) -> Option<Failure> {
        if self.is_stopped {
            return None;
        }
        let (Some(paced), Some(last)) = (&self.paced, &mut self.last) else {
            return None;
        };
        let until = self.run.plan.until?;
        match paced.state_at(last, (&self.integrator).into(), until) {
            Ok(state) => {
                self.end = Some((until, state));
                None
            }
            Err(error) => Some(self.failure_of_step(&error)),
        }
    }
}
