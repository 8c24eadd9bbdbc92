//! What a run records, and where it ends, between two steps.

use super::Session;
use crate::error::RunError;
use crate::events::Lost;
use crate::last_step::Between;
use crate::outcome::Failure;

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

    /// Records where the last step crosses the section; why that is not known.
    pub(super) fn record_crossing(&mut self) -> Result<Option<Failure>, RunError> {
        let (Some(section), Some(last)) = (&mut self.section, &mut self.last) else {
            return Ok(None);
        };
        let (side, found) = match section.crossing(last, self.integrator.state()) {
            Ok(crossing) => crossing,
            Err(lost) => return Ok(Some(self.failure_of(lost))),
        };
        if let Some(found) = found {
            let time = self.time_of(&found);
            if !self.is_on_the_way(time) {
                return Ok(None);
            }
            self.fill_row(&found.state);
            if let Some(crossings) = &mut self.crossings {
                crossings.push(time, &self.shown, &self.row)?;
            }
        }
        if let Some(section) = &mut self.section {
            section.side = side;
        }
        Ok(None)
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
        loop {
            let (Some(paced), Some(last)) = (&self.paced, &mut self.last) else {
                return Ok(None);
            };
            let is_passed = |time: &f64| match &self.end {
                // The end itself is recorded as the end.
                Some((end, _)) => paced.is_before(*time, *end),
                None => !paced.is_before(paced.time(&self.integrator), *time),
            };
            let time = paced.time_of_sample(self.samples.count());
            let Some(time) = time.filter(is_passed) else {
                return Ok(None);
            };
            match paced.state_at(last, (&self.integrator).into(), time) {
                Ok(state) => self.record_state(time, &state)?,
                Err(error) => return Ok(Some(self.failure_of_step(&error))),
            }
        }
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
