//! What happens between two steps: the end of a run, where a condition begins to hold, and where it crosses a section.

use leafwise_core::{BuildError, StepError};
use leafwise_scene::compose::{ComposedRun, Section, Stop};
use serde::{Deserialize, Serialize};

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

/// Where a run stands beside its section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Side {
    /// The sign of left − right where the run was last off the section: 1, −1, or 0 where it has left it to none.
    sign: f64,
    /// left − right after the last step.
    value: f64,
    /// The largest |left − right| in the last step, as far as it is known.
    largest: f64,
    /// The same in all steps.
    reach: f64,
    /// Whether the sign changed in the last step.
    is_changed: bool,
}

impl Side {
    /// At the initial state.
    pub fn begin(value: f64) -> Self {
        Self {
            sign: sign(value, 0.0),
            value,
            largest: value.abs(),
            reach: value.abs(),
            is_changed: false,
        }
    }

    /// Where nothing is to be looked for in a step after which left − right has this value: the side then.
    pub fn stays(self, value: f64) -> Option<Self> {
        let is_off = value * self.sign > 0.0 && !self.may_begin_and_end_there(value);
        is_off.then(|| self.after(value, value, self.sign))
    }

    /// Whether a step may begin and end on the section. Where nothing but 0 was seen, how large the values are is not known.
    fn may_begin_and_end_there(self, value: f64) -> bool {
        self.reach == 0.0 || self.value.abs().max(value.abs()) <= JUMP * self.reach
    }

    /// After a step, of which one more value is known.
    fn after(self, value: f64, other: f64, sign: f64) -> Self {
        let largest = self.value.abs().max(value.abs()).max(other.abs());
        Self {
            sign,
            value,
            largest,
            reach: self.reach.max(largest),
            is_changed: self.sign * sign < 0.0,
        }
    }

    /// Whether the run ends on the section and comes from a side, in a direction that counts; a crossing in the last step is that one.
    pub fn ends_there(self, section: &Section, value: f64, steps: u64) -> bool {
        !self.is_changed
            && self.sign != 0.0
            && section.counts(-self.sign)
            && value.abs() <= round_off(steps) * self.largest
    }
}

/// What is no distance from the section after so many steps, as a part of the largest |left − right| in a step: the time, and what goes
/// as it does, is rounded to so much of a step.
fn round_off(steps: u64) -> f64 {
    CLOSE * steps.max(1) as f64
}

/// The section whose crossings are recorded.
pub(super) struct Crossings<'a> {
    section: &'a Section,
    difference: Functions,
    /// Where the run stands after the last step.
    pub side: Side,
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
        let side = Side::begin(difference.at(&run.plan.initial)[0]);
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
        steps: u64,
    ) -> Result<(Side, Option<Between>), Lost<'a>> {
        let difference = &mut self.difference;
        let value = difference.at(after)[0];
        let difference = &mut |state: &[f64]| difference.at(state)[0];
        crossing(
            self.section,
            difference,
            last,
            after,
            (self.side, value, steps),
        )
    }

    /// Whether the run ends on the section, which it crosses there.
    pub fn ends_there(&mut self, state: &[f64], steps: u64) -> bool {
        let value = self.difference.at(state)[0];
        self.side.ends_there(self.section, value, steps)
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

    /// The side after the last step, and where the step crosses it.
    pub fn crossing(
        &mut self,
        last: &mut LastStep<'_>,
        after: &[f64],
        steps: u64,
    ) -> Result<(Side, Option<Between>), Lost<'a>> {
        self.crossings.crossing(last, after, steps)
    }

    /// Takes in on which side the run goes on.
    pub fn go_on(&mut self, side: Side) {
        self.crossings.side = side;
    }

    /// Takes in a crossing; whether the run ends there.
    pub fn take(&mut self, crossing: Crossing) -> bool {
        self.found.push(crossing);
        self.event.last == Some(self.found.len() as u64)
    }

    /// Whether the run ends on the surface, which it crosses there.
    pub fn ends_there(&mut self, state: &[f64], steps: u64) -> bool {
        self.crossings.ends_there(state, steps)
    }
}

/// The side after the last step, and where the step crosses the section in a direction that counts; before it the `side` is known, and
/// left − right has this `value` `after` it.
///
/// A state on the section keeps the side from which it was reached. A value that jumps over zero, or has a pole, crosses nothing. Of a
/// step that begins and ends on the section the side is that of its middle, and it crosses where it begins.
pub(super) fn crossing<'a>(
    section: &'a Section,
    difference: &mut dyn FnMut(&[f64]) -> f64,
    last: &mut LastStep<'_>,
    after: &[f64],
    (side, value, steps): (Side, f64, u64),
) -> Result<(Side, Option<Between>), Lost<'a>> {
    if value.is_nan() {
        return Err(Lost::Undefined(&section.text));
    }
    if let Some(side) = side.stays(value) {
        return Ok((side, None));
    }
    if side.may_begin_and_end_there(value) {
        let middle = last.part(0.5).map_err(Lost::Step)?;
        let inside = difference(&middle);
        let ends = side.value.abs().max(value.abs());
        if inside.is_finite() && inside != 0.0 && ends <= round_off(steps) * inside.abs() {
            let found = side.after(value, inside, sign(inside, 0.0));
            let crosses = found.is_changed && section.counts(found.sign);
            let begin = Between {
                part: 0.0,
                state: last.start.state.clone(),
                value: side.value,
            };
            // The section is reached once more at the end.
            let found = Side {
                is_changed: false,
                ..found
            };
            return Ok((found, crosses.then_some(begin)));
        }
    }
    let other = side.after(value, value, sign(value, side.sign));
    if !other.is_changed || !section.counts(other.sign) {
        return Ok((other, None));
    }
    let ends = [side.value * other.sign, value * other.sign];
    let mut rising = |_: &[f64], state: &[f64]| difference(state) * other.sign;
    let largest = other.largest;
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
fn sign(value: f64, zero: f64) -> f64 {
    if value == 0.0 {
        zero
    } else {
        1.0_f64.copysign(value)
    }
}
