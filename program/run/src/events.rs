//! What happens between two steps: the end of a run, where a condition begins to hold, and where it crosses a section.

use leafwise_core::{BuildError, StepError};
use leafwise_scene::compose::{ComposedRun, Section, Stop};

use super::invariants::Functions;
use super::last_step::{Between, CLOSE, LastStep};

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

    /// As [`end`].
    pub fn end(
        &mut self,
        last: &mut LastStep<'_>,
        after: &[f64],
    ) -> Result<Option<Between>, Lost<'a>> {
        let difference = &mut self.difference;
        let value = difference.at(after)[0];
        let difference = &mut |state: &[f64]| difference.at(state)[0];
        end(self.stop, difference, last, after, value)
    }
}

/// The first state of the last step at which a condition holds, to round-off; `None` where it does not hold `after` the
/// step, where its difference has this `value`.
pub(super) fn end<'a>(
    stop: &'a Stop,
    difference: &mut dyn FnMut(&[f64]) -> f64,
    last: &mut LastStep<'_>,
    after: &[f64],
    value: f64,
) -> Result<Option<Between>, Lost<'a>> {
    if value.is_nan() {
        return Err(Lost::Undefined(&stop.text));
    }
    if !stop.holds(value) {
        return Ok(None);
    }
    let ends = [difference(&last.start.state), value];
    let value = &mut |_: &[f64], state: &[f64]| difference(state);
    last.enclose(after, ends, &|value| stop.holds(value), None, value)
        .map(|bracket| Some(bracket.behind))
        .map_err(Lost::Step)
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
        let section = run.plan.events.section.as_ref();
        section.map(|section| Self::with(run, section)).transpose()
    }

    /// Those of any section.
    fn with(run: &ComposedRun, section: &'a Section) -> Result<Self, BuildError> {
        let mut difference = Functions::compile(run, &[&section.difference])?;
        let side = sign(difference.at(&run.plan.initial)[0], 0.0);
        Ok(Self {
            section,
            difference,
            side,
        })
    }

    /// As [`crossing`], with the side after the step.
    pub fn crossing(
        &mut self,
        last: &mut LastStep<'_>,
        after: &[f64],
    ) -> Result<(f64, Option<Between>), Lost<'a>> {
        let difference = &mut self.difference;
        let value = difference.at(after)[0];
        let difference = &mut |state: &[f64]| difference.at(state)[0];
        crossing(self.section, difference, last, after, (self.side, value))
    }
}

/// A surface that a run in memory looks for, beside its scene's own section.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The surface, and which crossings count.
    pub section: Section,
    /// The crossing that ends the run, counted from 1, where one does.
    pub last: Option<u64>,
}

/// Where a run crosses a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// The time.
    pub time: f64,
    /// The scene's own coordinates.
    pub state: Vec<f64>,
}

/// An event that is looked for, with what was found.
pub(super) struct EventWatch<'a> {
    event: &'a Event,
    crossings: Crossings<'a>,
    pub found: Vec<Crossing>,
}

impl<'a> EventWatch<'a> {
    /// Nothing found yet.
    pub fn new(run: &ComposedRun, event: &'a Event) -> Result<Self, BuildError> {
        Ok(Self {
            event,
            crossings: Crossings::with(run, &event.section)?,
            found: Vec::new(),
        })
    }

    /// The surface in words.
    pub fn text(&self) -> &'a str {
        &self.event.section.text
    }

    /// Where the last step crosses it.
    pub fn crossing(
        &mut self,
        last: &mut LastStep<'_>,
        after: &[f64],
    ) -> Result<Option<Between>, Lost<'a>> {
        let (side, found) = self.crossings.crossing(last, after)?;
        self.crossings.side = side;
        Ok(found)
    }

    /// Takes in a crossing; whether the run ends there.
    pub fn take(&mut self, crossing: Crossing) -> bool {
        self.found.push(crossing);
        self.event.last == Some(self.found.len() as u64)
    }
}

/// The side after the last step, the same as before where the state lies on the section, and where the step crosses it in a
/// direction that counts; before it the `side` is known, and left − right has this `value` `after` it. A value that jumps
/// over zero, or has a pole, crosses nothing.
pub(super) fn crossing<'a>(
    section: &'a Section,
    difference: &mut dyn FnMut(&[f64]) -> f64,
    last: &mut LastStep<'_>,
    after: &[f64],
    (side, value): (f64, f64),
) -> Result<(f64, Option<Between>), Lost<'a>> {
    if value.is_nan() {
        return Err(Lost::Undefined(&section.text));
    }
    let other = sign(value, side);
    if side * other >= 0.0 || !section.counts(other) {
        return Ok((other, None));
    }
    let ends = [difference(&last.start.state) * other, value * other];
    let mut rising = |_: &[f64], state: &[f64]| difference(state) * other;
    let largest = ends[0].abs().max(ends[1].abs());
    let bracket = last
        .enclose(
            after,
            ends,
            &|v| v >= 0.0,
            Some(CLOSE * largest),
            &mut rising,
        )
        .map_err(Lost::Step)?;
    let found = bracket.nearest;
    let crosses = found.value.abs() <= JUMP * largest;
    Ok((other, crosses.then_some(found)))
}

/// The sign of a value, and what stands for it where that is zero.
pub(super) fn sign(value: f64, zero: f64) -> f64 {
    if value == 0.0 {
        zero
    } else {
        1.0_f64.copysign(value)
    }
}
