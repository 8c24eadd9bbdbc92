//! The looks at a step.

use leafwise_core::{BuildError, StepError};

use super::Watched;
use super::lanes::{EventLanes, StopLanes};
use crate::domain::outside;
use crate::events::end;
use crate::fault::{Ended, Fault, Why};
use crate::look::Look;
use crate::pace::Pace;
use crate::step::{Between, LastStep, StepEnd};
use crate::times::is_same_time;

/// The time of a state within the last of so many steps.
pub(super) fn time_of(
    pace: Option<&Pace>,
    last: &LastStep<'_>,
    steps: u64,
    between: &Between,
) -> f64 {
    match pace {
        Some(pace) => pace.time_at(&between.state),
        None => last.time(steps, between.part),
    }
}

impl Watched<'_> {
    /// Ends the lanes whose time does not advance as it should: at the state before the step, since the one that was reached is none of
    /// the motion's.
    pub(super) fn look_at_paces(&mut self) -> Result<(), BuildError> {
        if self.course.pace.is_none() {
            return Ok(());
        }
        let (steps, lanes) = (self.walk.steps(), self.walk.lanes());
        for lane in 0..lanes {
            if !self.walk.lives(lane) {
                continue;
            }
            let after = StepEnd::of(&self.walk, lane);
            let alone = self.alones.at(lane, &self.start)?;
            let Some(watch) = &mut alone.pace else {
                continue;
            };
            std::mem::swap(&mut watch.steps, &mut self.paced[lane]);
            let fault = watch.take(&alone.last, &after, steps);
            std::mem::swap(&mut watch.steps, &mut self.paced[lane]);
            if let Some(fault) = fault {
                let before = alone.last.start.state.clone();
                let ended = Ended {
                    why: Why::Failed(fault.into()),
                    steps: steps - 1,
                    time: self.course.time(steps - 1, &before),
                    state: before,
                    is_between: false,
                };
                self.end(lane, ended);
            }
        }
        Ok(())
    }

    /// Ends the lanes that end where they begin.
    pub(super) fn look_at_initial_states(&mut self) {
        for at in 0..self.events.len() {
            let EventLanes { event, values, .. } = &self.events[at];
            let text = event.section.text.clone();
            // Behind left − right of every lane stand the values that the event sets.
            let differences = values.last().iter().take(self.walk.lanes());
            let undefined: Vec<bool> = differences.map(|value| value.is_nan()).collect();
            for (lane, is_undefined) in undefined.into_iter().enumerate() {
                if is_undefined && self.walk.lives(lane) {
                    self.fail(lane, Fault::Undefined(text.clone()), 0);
                }
            }
        }
        let Some(StopLanes { stop, values, .. }) = &mut self.stop else {
            return;
        };
        // Behind the differences of all lanes stand those of corners.
        let (stop, values) = (*stop, values.at(self.walk.state()));
        let values = values[..self.walk.lanes()].to_vec();
        for (lane, value) in values.into_iter().enumerate() {
            if !self.walk.lives(lane) {
                continue;
            }
            if value.is_nan() {
                self.fail(lane, Fault::Undefined(stop.text.clone()), 0);
            } else if stop.holds(value) {
                let ended = Ended {
                    why: Why::Stopped,
                    steps: 0,
                    time: 0.0,
                    state: self.present(lane),
                    is_between: false,
                };
                self.end(lane, ended);
            }
        }
    }

    /// Ends the lanes that the condition ends in the last step.
    pub(super) fn look_for_stops(&mut self) -> Result<(), BuildError> {
        let Some(own) = &mut self.stop else {
            return Ok(());
        };
        let stop = own.stop;
        let looks = |value: f64| stop.holds(value) || value.is_nan();
        let steps = self.walk.steps();
        own.values.at(self.walk.state());
        // Most steps end no lane.
        let mut asked = Vec::new();
        for (lane, past) in own.pasts.iter_mut().enumerate() {
            if !self.walk.lives(lane) || past.has_seen(steps) {
                continue;
            }
            let all = own.values.last();
            let value = all[lane];
            if looks(value) || !past.shows_all(value) || own.corners.may_be_passed(lane, all) {
                asked.push((lane, value));
            } else {
                *past = past.then(value);
                own.corners.go_on(lane, steps, all);
            }
        }
        for (lane, value) in asked {
            let after = self.present(lane);
            let Some(own) = &mut self.stop else {
                return Ok(());
            };
            let seen = (own.pasts[lane], own.corners.of(lane), value);
            let alone = self.alones.at(lane, &self.start)?;
            let (Some(values), last) = (&mut alone.stop, &mut alone.last) else {
                continue;
            };
            match end(stop, values, last, &after, seen) {
                Err(fault) => self.fail(lane, fault, steps),
                Ok(None) => own.go_on(lane, steps, value),
                Ok(Some(between)) => {
                    let pace = self.course.pace.as_ref();
                    let time = time_of(pace, &alone.last, steps, &between);
                    if self.is_on_the_way(lane, time) {
                        self.end_between(lane, Why::Stopped, time, between.state);
                    }
                }
            }
        }
        Ok(())
    }

    /// Ends the lanes that the condition ends in the part of a step before it leaves a table.
    pub(super) fn look_for_stops_on_the_way(&mut self) -> Result<(), BuildError> {
        if self.stop.is_none() {
            return Ok(());
        }
        for (lane, error) in self.walk.failed().to_vec() {
            if !matches!(error, StepError::OutsideTable(_)) || self.ends[lane].is_some() {
                continue;
            }
            let steps = self.walk.last(lane).0 + 1;
            let alone = self.alones.at(lane, &self.start)?;
            let (Some(own), Some(values)) = (&self.stop, &mut alone.stop) else {
                continue;
            };
            let (stop, last) = (own.stop, &mut alone.last);
            let found = last.reached(|state| stop.holds(values.at(state)[0]));
            let Some((part, after)) = found else {
                continue;
            };
            let value = values.at(&after)[0];
            let seen = (own.pasts[lane], own.corners.of(lane), value);
            let within = last.within(part, |last| end(stop, values, last, &after, seen));
            if let Ok(Some(between)) = within {
                let between = Between {
                    part: part * between.part,
                    ..between
                };
                let time = time_of(self.course.pace.as_ref(), last, steps, &between);
                if self.is_on_the_way(lane, time) {
                    let ended = Ended {
                        why: Why::Stopped,
                        steps,
                        time,
                        state: between.state,
                        is_between: true,
                    };
                    self.end(lane, ended);
                }
            }
        }
        Ok(())
    }

    pub(super) fn end_between(&mut self, lane: usize, why: Why, time: f64, state: Vec<f64>) {
        let ended = Ended {
            why,
            steps: self.walk.steps(),
            time,
            state,
            is_between: true,
        };
        self.end(lane, ended);
    }

    /// Whether a time comes before a lane's end, where that is known.
    pub(super) fn is_on_the_way(&self, lane: usize, time: f64) -> bool {
        let ended = self.ends[lane].as_ref().map(|ended| ended.time);
        let end = ended.or(self.course.until);
        end.is_none_or(|end| !self.course.is_before(end, time))
    }

    /// Evaluates the invariants: whether some lane is inside of the energy's domain, and the lanes that have left it. Where the energy is
    /// infinite, or a Casimir has no value, the motion may be regular: it goes on.
    pub(super) fn look_at_invariants(&mut self) -> (bool, Vec<usize>) {
        let values = self.invariants.at(self.walk.state());
        if values.iter().all(|value| value.is_finite()) {
            return (true, Vec::new());
        }
        let outside = self.outside();
        let is_some_inside = outside.contains(&false);
        let lanes = outside.into_iter().enumerate();
        let lost = lanes.filter(|(lane, outside)| *outside && self.walk.lives(*lane));
        (is_some_inside, lost.map(|(lane, _)| lane).collect())
    }

    /// For each lane, whether its state is outside the energy's domain.
    pub(super) fn outside(&mut self) -> Vec<bool> {
        let lanes = self.walk.lanes();
        let invariants = &mut self.invariants;
        let energies = |state: &[f64], is_nan: &mut Vec<bool>| {
            let energies = &invariants.at(state)[..lanes];
            is_nan.extend(energies.iter().map(|value| value.is_nan()));
        };
        let outside = outside(self.walk.state(), lanes, energies);
        self.invariants.at(self.walk.state());
        outside
    }

    /// Takes in the states at the times that lanes have passed in the last step.
    pub(super) fn take_times<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        if self.course.samples.are_steps() {
            return Ok(());
        }
        for lane in 0..self.walk.lanes() {
            while self.moved[lane] && !self.has_failed(lane) {
                let present = self.time(lane);
                let Some(time) = self.passed_time(lane, present) else {
                    break;
                };
                self.take_time(lane, time, take)?;
            }
        }
        Ok(())
    }

    fn take_time<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        lane: usize,
        time: f64,
        take: &mut F,
    ) -> Result<(), E> {
        let (steps, present) = (self.walk.steps(), self.time(lane));
        let number = self.next[lane];
        let after = StepEnd::of(&self.walk, lane);
        let alone = self.alones.at(lane, &self.start)?;
        let is_met = self.course.pace.is_none() && is_same_time(present, time);
        let found = match &alone.pace {
            Some(pace) => pace.state_at(&mut alone.last, &after, time),
            None if is_met => Ok(after.state.to_vec()),
            None => alone.last.state_at(steps, time),
        };
        match found {
            Ok(state) => {
                self.next[lane] += 1;
                take(Look::Sample {
                    lane,
                    number,
                    time,
                    state: &state,
                    steps: is_met.then_some(steps),
                })
            }
            Err(error) => {
                self.fail(lane, error.into(), steps);
                Ok(())
            }
        }
    }

    /// The time of a lane's next sample, where the last step has passed it on the way to its `present` time.
    pub(super) fn passed_time(&self, lane: usize, present: f64) -> Option<f64> {
        let course = self.course;
        let time = course.samples.time(self.next[lane], course.step())?;
        // The end itself is recorded as the end.
        let ended = self.ends[lane].as_ref().map(|ended| ended.time);
        let is_end = |end: f64| course.samples.is_end(time, end, course.until);
        let is_ahead = |end: f64| course.is_before(time, end) && !is_end(end);
        if !ended.into_iter().chain(course.until).all(is_ahead) {
            return None;
        }
        let is_met = course.pace.is_none() && is_same_time(present, time);
        (is_met || !course.is_before(present, time)).then_some(time)
    }

    /// Ends the lanes that have come to the end of the course.
    ///
    /// # Errors
    /// [`BuildError`] where a function has no evaluator.
    pub fn arrive(&mut self) -> Result<(), BuildError> {
        let (steps, lanes) = (self.walk.steps(), self.walk.lanes());
        for lane in 0..lanes {
            if !self.walk.lives(lane) {
                continue;
            }
            if !self.is_there(lane) {
                continue;
            }
            let (Some(_), Some(until)) = (&self.course.pace, self.course.until) else {
                let ended = Ended {
                    why: Why::Done,
                    steps,
                    time: self.time(lane),
                    state: self.present(lane),
                    is_between: false,
                };
                self.end(lane, ended);
                continue;
            };
            let after = StepEnd::of(&self.walk, lane);
            let alone = self.alones.at(lane, &self.start)?;
            let Some(pace) = &alone.pace else {
                continue;
            };
            match pace.state_at(&mut alone.last, &after, until) {
                Ok(state) => self.end_between(lane, Why::Done, until, state),
                Err(error) => self.fail(lane, error.into(), steps),
            }
        }
        Ok(())
    }
}
