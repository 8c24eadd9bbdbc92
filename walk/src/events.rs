//! Events between two steps: the end of a walk, where a condition begins to hold, and where it crosses a surface.

use leafwise_expression::Expression;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::step::{Between, CLOSE, LastStep};

/// A condition that ends a walk, as `q > 1 or t >= 10`.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The condition as it is written.
    pub text: String,
    /// A function of the state that is stepped: positive where the condition holds, negative where it does not.
    pub difference: Expression,
}

impl Stop {
    /// Whether the condition holds where the difference has this value.
    pub fn holds(&self, difference: f64) -> bool {
        difference > 0.0
    }
}

/// Which crossings of a surface count, on the way of the walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// From left < right to left > right.
    Up,
    /// From left > right to left < right.
    Down,
    /// All.
    #[default]
    Both,
}

/// A surface, left = right.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// The surface as it is written.
    pub text: String,
    /// Left − right, a function of the state that is stepped.
    pub difference: Expression,
    /// Which crossings count.
    pub direction: Direction,
}

impl Event {
    /// Left − right, then the values that coordinates take.
    pub fn formulas(&self) -> Vec<&Expression> {
        let set = self.act.iter().flat_map(|act| &act.set);
        let set = set.map(|(_, value)| value);
        std::iter::once(&self.section.difference)
            .chain(set)
            .collect()
    }
}

impl Section {
    /// Whether a crossing to this side counts: 1 where left > right, −1 where left < right.
    pub fn counts(&self, side: f64) -> bool {
        match self.direction {
            Direction::Up => side > 0.0,
            Direction::Down => side < 0.0,
            Direction::Both => true,
        }
    }

    /// Which crossings, in words.
    pub fn direction_in_words(&self) -> &'static str {
        match self.direction {
            Direction::Up => "upwards",
            Direction::Down => "downwards",
            Direction::Both => "in both directions",
        }
    }
}

/// A change of the state where a walk crosses a surface: coordinates take values of formulas of the state before, all at once.
#[derive(Clone, Debug, PartialEq)]
pub struct Act {
    /// The change as it is written.
    pub text: String,
    /// Coordinates and their values.
    pub set: Vec<(usize, Expression)>,
}

/// A surface that a walk looks for, and whether it ends there.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The surface, and which crossings count.
    pub section: Section,
    /// What happens to the state there, if anything does.
    pub act: Option<Act>,
    /// The crossing that ends the walk, counted from 1, where one does.
    pub last: Option<u64>,
}

/// The first state of the last step at which a condition holds, to round-off; `None` where it does not hold `after` the
/// step, where its difference has this `value`.
pub(crate) fn end(
    stop: &Stop,
    difference: &mut dyn FnMut(&[f64]) -> f64,
    last: &mut LastStep<'_>,
    after: &[f64],
    value: f64,
) -> Result<Option<Between>, Fault> {
    if value.is_nan() {
        return Err(Fault::Undefined(stop.text.clone()));
    }
    if !stop.holds(value) {
        return Ok(None);
    }
    let ends = [difference(&last.start.state), value];
    let value = &mut |_: &[f64], state: &[f64]| difference(state);
    last.enclose(after, ends, &|value| stop.holds(value), None, value)
        .map(|bracket| Some(bracket.behind))
        .map_err(Fault::Step)
}

/// The largest part of the values before and after a step that is left where they cross zero: beyond it they jump over it.
const JUMP: f64 = 1e-6;

/// Where a run stands beside its section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Side {
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

    /// Behind an event that has changed the state: left − right there, and the side that the motion leaves to, 1 or −1.
    pub(crate) fn behind(self, value: f64, sign: f64) -> Self {
        Self {
            sign,
            value,
            largest: self.largest,
            reach: self.reach.max(value.abs()),
            is_changed: false,
        }
    }

    /// Whether a value counts as on the surface after so many steps.
    pub(crate) fn is_on(&self, value: f64, steps: u64) -> bool {
        value.abs() <= round_off(steps) * self.largest
    }

    /// The side on which the walk is.
    pub(crate) fn sign(&self) -> f64 {
        self.sign
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

/// Distance from the section below which a value counts as on it after so many steps, relative to the largest
/// |left − right| in a step. The time, and all that advances as it does, is rounded to this fraction of a step.
fn round_off(steps: u64) -> f64 {
    CLOSE * steps.max(1) as f64
}

/// Side of the section after the last step, and where the step crosses it in a direction that counts. The argument
/// `side` is the side before the step, `value` is left − right at the state `after` it.
///
/// A state on the section keeps the side from which it was reached. A value that jumps over zero, or has a pole,
/// crosses nothing. Of a step that begins and ends on the section the side is that of its middle, and it crosses where
/// it begins.
pub(crate) fn crossing(
    section: &Section,
    difference: &mut dyn FnMut(&[f64]) -> f64,
    last: &mut LastStep<'_>,
    after: &[f64],
    (side, value, steps): (Side, f64, u64),
) -> Result<(Side, Option<Between>), Fault> {
    if value.is_nan() {
        return Err(Fault::Undefined(section.text.clone()));
    }
    if let Some(side) = side.stays(value) {
        return Ok((side, None));
    }
    if side.may_begin_and_end_there(value) {
        let middle = last.part(0.5).map_err(Fault::Step)?;
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
        .map_err(Fault::Step)?;
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
