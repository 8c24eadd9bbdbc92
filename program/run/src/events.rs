//! What happens between two steps: the end of a run, where a condition begins to hold, and where it crosses a section.

use leafwise_core::{BuildError, Integrator, StepError};
use leafwise_scene::compose::{ComposedRun, Section, Stop};

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

/// The largest part of the values before and after a step that is left where they cross zero: beyond it they jump over it.
const JUMP: f64 = 1e-6;

/// The section whose crossings are recorded.
pub(super) struct Crossings<'a> {
    section: &'a Section,
    difference: Functions,
    /// The sign of the last value that was not zero.
    pub side: f64,
}

impl<'a> Crossings<'a> {
    /// `None` where a run has none.
    pub fn of(run: &'a ComposedRun) -> Result<Option<Self>, BuildError> {
        let Some(section) = &run.plan.events.section else {
            return Ok(None);
        };
        let mut difference = Functions::compile(run, &[&section.difference])?;
        let side = sign(difference.at(&run.plan.initial)[0], 0.0);
        Ok(Some(Self {
            section,
            difference,
            side,
        }))
    }

    /// The side after the last step: the same as before where the state lies on the section.
    pub fn side_after(&mut self, integrator: &Integrator) -> Result<f64, Lost<'a>> {
        let value = self.difference.at(integrator.state())[0];
        if value.is_nan() {
            return Err(Lost::Undefined(&self.section.text));
        }
        Ok(sign(value, self.side))
    }

    /// Where the last step, which ends on this side, crosses the section in a direction that counts. A value that jumps over
    /// zero, or has a pole, crosses nothing.
    pub fn crossing(
        &mut self,
        last: &LastStep<'_>,
        integrator: &Integrator,
        side: f64,
    ) -> Result<Option<Between>, StepError> {
        if self.side * side >= 0.0 || !self.section.counts(side) {
            return Ok(None);
        }
        let difference = &mut self.difference;
        let mut value = |_: &[f64], state: &[f64]| difference.at(state)[0] * side;
        let ends = [&last.start.state, integrator.state()].map(|state| value(&[], state));
        let bracket = last.enclose(integrator, ends, &|v| v >= 0.0, Some(0.0), &mut value)?;
        let largest = ends[0].abs().max(ends[1].abs());
        let found = bracket.nearest;
        Ok((found.value.abs() <= JUMP * largest).then_some(found))
    }
}

/// The sign of a value, and what stands for it where that is zero.
fn sign(value: f64, zero: f64) -> f64 {
    if value == 0.0 {
        zero
    } else {
        1.0_f64.copysign(value)
    }
}
