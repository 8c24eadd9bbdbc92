//! What happens between two steps: the end of a run where a condition begins to hold.

use leafwise_core::{BuildError, Integrator, StepError};
use leafwise_scene::compose::{ComposedRun, Stop};

use super::invariants::Functions;
use super::last_step::{Between, LastStep};

/// Why an event was not found.
pub(super) enum Lost<'a> {
    /// A formula, by its text, that has no value after the last step.
    Undefined(&'a str),
    /// A shorter step that could not be taken.
    Step(StepError),
}

/// The condition that ends a run.
pub(super) struct StopWatch<'a> {
    stop: &'a Stop,
    difference: Functions,
}

impl<'a> StopWatch<'a> {
    /// `None` where a run has none.
    pub fn of(run: &'a ComposedRun) -> Result<Option<Self>, BuildError> {
        let Some(stop) = &run.plan.events.stop else {
            return Ok(None);
        };
        let difference = Functions::compile(run, &[&stop.difference])?;
        Ok(Some(Self { stop, difference }))
    }

    /// The condition as the scene writes it.
    pub fn text(&self) -> &'a str {
        &self.stop.text
    }

    /// The first state of the last step at which the condition holds, to round-off; `None` where it does not hold after
    /// the step.
    pub fn end(
        &mut self,
        last: &LastStep<'_>,
        integrator: &Integrator,
    ) -> Result<Option<Between>, Lost<'a>> {
        let (stop, difference) = (self.stop, &mut self.difference);
        let value = difference.at(integrator.state())[0];
        if value.is_nan() {
            return Err(Lost::Undefined(&stop.text));
        }
        if !stop.holds(value) {
            return Ok(None);
        }
        let ends = [difference.at(&last.start.state)[0], value];
        let value = &mut |_: &[f64], state: &[f64]| difference.at(state)[0];
        last.enclose(integrator, ends, &|value| stop.holds(value), None, value)
            .map(|bracket| Some(bracket.behind))
            .map_err(Lost::Step)
    }
}
