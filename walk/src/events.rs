//! Events between two steps: the end of a walk, where a condition begins to hold, and where it crosses a surface.

use leafwise_expression::Expression;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::functions::FunctionValues;
use crate::step::{Between, CLOSE, LastStep};
use crate::turns::{Past, changes, corners, is_off, largest, sign};

/// A condition that ends a walk, as `q > 1 or t >= 10`.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The condition as it is written.
    pub text: String,
    /// A function of the state that is stepped: positive where the condition holds, negative where it does not.
    pub difference: Expression,
}

impl Stop {
    /// The difference, then its [corners](Expression::corners).
    pub fn formulas(&self) -> Vec<Expression> {
        let mut formulas = vec![self.difference.clone()];
        formulas.extend(self.difference.corners());
        formulas
    }

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
    /// Left − right, then the values that coordinates take, then the [corners](Expression::corners) of the first.
    pub fn formulas(&self) -> Vec<Expression> {
        let set = self.act.iter().flat_map(|act| &act.set);
        let set = set.map(|(_, value)| value.clone());
        std::iter::once(self.section.difference.clone())
            .chain(set)
            .chain(self.section.difference.corners())
            .collect()
    }

    /// How many of the formulas are no corners.
    pub(crate) fn first_corner(&self) -> usize {
        1 + self.act.as_ref().map_or(0, |act| act.set.len())
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
    /// The change of the state there, if there is one.
    pub act: Option<Act>,
    /// The crossing that ends the walk, counted from 1, where one does.
    pub last: Option<u64>,
}

/// The first state of the last step at which a condition holds, to round-off; `None` where it holds nowhere in the step, as
/// far as values `past` show. So do those of its corners. Its difference has this `value` at the state `after` the step.
pub(crate) fn end(
    stop: &Stop,
    values: &mut FunctionValues,
    last: &mut LastStep<'_>,
    after: &[f64],
    (past, corner_pasts, value): (Past, &[Past], f64),
) -> Result<Option<Between>, Fault> {
    if value.is_nan() {
        return Err(Fault::Undefined(stop.text.clone()));
    }
    let begins = values.at(&last.start.state)[0];
    let mut ends = last.ends(after, [begins, value]);
    let corners = corners(last, &ends, values, (1, corner_pasts));
    let difference = &mut |state: &[f64]| values.at(state)[0];
    if !corners.is_empty() || !past.shows_all(value) {
        let mut points = past.points(last, (ends.clone(), corners), difference);
        let largest = largest(&points);
        let inner = 1..points.len() - 1;
        let is_it =
            |at: &usize| stop.holds(points[*at].value) && is_off(points[*at].value, largest);
        if let Some(at) = inner.clone().find(is_it) {
            ends = [points.swap_remove(at - 1), points.swap_remove(at)];
        }
    }
    if !stop.holds(ends[1].value) {
        return Ok(None);
    }
    let value = &mut |_: &[f64], state: &[f64]| difference(state);
    last.enclose(ends, &|value| stop.holds(value), None, value)
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
    /// left − right after the last steps.
    past: Past,
    /// The largest |left − right| in the last step, as far as it is known.
    largest: f64,
    /// The same in all steps.
    reach: f64,
    /// Whether the section was crossed in the last step.
    is_changed: bool,
    /// How many crossings of the next step were taken in before the walk ended there.
    taken: u64,
}

impl Side {
    /// At the initial state.
    pub fn begin(value: f64) -> Self {
        Self {
            sign: sign(value, 0.0),
            past: Past::begin(value),
            largest: value.abs(),
            reach: value.abs(),
            is_changed: false,
            taken: 0,
        }
    }

    /// Behind an event that has changed the state within the next step. Left − right has this value there, and the motion leaves
    /// to the side of this sign. The side after the whole step would have been `crossed`.
    pub(crate) fn behind(self, crossed: Self, value: f64, sign: f64) -> Self {
        Self {
            sign,
            past: self.past.begun_again(value),
            largest: crossed.largest,
            reach: crossed.reach.max(value.abs()),
            is_changed: false,
            taken: 0,
        }
    }

    /// The same where the next step ends with the event, which is its crossing.
    pub(crate) fn with_step(self) -> Self {
        Self {
            past: self.past.then(self.past.value()),
            is_changed: true,
            ..self
        }
    }

    /// The sign of a value; on the surface that of the side from which it was reached.
    pub(crate) fn sign_of(&self, value: f64) -> f64 {
        sign(value, self.sign)
    }

    /// Whether a value counts as on the surface after so many steps.
    pub(crate) fn is_on(&self, value: f64, steps: u64) -> bool {
        value.abs() <= round_off(steps) * self.largest
    }

    /// The side behind the first crossing that counts.
    pub(crate) fn across(&self, section: &Section) -> f64 {
        match section.direction {
            Direction::Up => 1.0,
            Direction::Down => -1.0,
            Direction::Both => -self.sign,
        }
    }

    /// Whether the value after so many steps is known.
    pub(crate) fn has_seen(&self, steps: u64) -> bool {
        self.past.has_seen(steps)
    }

    /// Where nothing is to be looked for in a step, the last of so many, after which left − right has this value: the side then.
    pub fn stays(self, value: f64, steps: u64) -> Option<Self> {
        if self.past.has_seen(steps) {
            return Some(self);
        }
        let is_off = value * self.sign > 0.0 && !self.may_begin_and_end_there(value);
        (is_off && self.past.shows_all(value)).then(|| self.after(value, value, self.sign))
    }

    /// Whether a step may begin and end on the section. Where nothing but 0 was seen, how large the values are is not known.
    fn may_begin_and_end_there(self, value: f64) -> bool {
        self.reach == 0.0 || self.past.value().abs().max(value.abs()) <= JUMP * self.reach
    }

    /// After a step, of which one more value is known.
    fn after(self, value: f64, other: f64, sign: f64) -> Self {
        let largest = self.past.value().abs().max(value.abs()).max(other.abs());
        Self {
            sign,
            past: self.past.then(value),
            largest,
            reach: self.reach.max(largest),
            is_changed: self.sign * sign < 0.0,
            taken: 0,
        }
    }

    /// How many crossings of the next step were taken in.
    pub(crate) fn taken(self) -> usize {
        self.taken as usize
    }

    /// In a step in which the walk has ended, of whose crossings so many were taken in.
    #[must_use]
    pub(crate) fn with_taken(self, taken: u64) -> Self {
        Self {
            taken: self.taken + taken,
            is_changed: self.is_changed || taken > 0,
            ..self
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

/// Side of the section after the last step, and where the step crosses it in directions that count, in order. The argument
/// `side` is the side before the step, `value` is left − right at the state `after` it.
///
/// A state on the section keeps the side from which it was reached. A value that jumps over zero, or has a pole,
/// crosses nothing. Of a step that begins and ends on the section the side is that of its middle, and it crosses where
/// it begins.
pub(crate) fn crossings(
    event: &Event,
    values: &mut FunctionValues,
    last: &mut LastStep<'_>,
    after: &[f64],
    (side, corner_pasts, value, steps): (Side, &[Past], f64, u64),
) -> Result<(Side, Vec<Between>), Fault> {
    let section = &event.section;
    if value.is_nan() {
        return Err(Fault::Undefined(section.text.clone()));
    }
    let ends = last.ends(after, [side.past.value(), value]);
    let corners = corners(last, &ends, values, (event.first_corner(), corner_pasts));
    if let (true, Some(side)) = (corners.is_empty(), side.stays(value, steps)) {
        return Ok((side, Vec::new()));
    }
    let difference = &mut |state: &[f64]| values.at(state)[0];
    if side.may_begin_and_end_there(value) {
        let middle = last.part(0.5).map_err(Fault::Step)?;
        let inside = difference(&middle);
        let ends = side.past.value().abs().max(value.abs());
        if inside.is_finite() && inside != 0.0 && ends <= round_off(steps) * inside.abs() {
            let found = side.after(value, inside, sign(inside, 0.0));
            let crosses = found.is_changed && section.counts(found.sign);
            let [begin, _] = last.ends(after, [side.past.value(), value]);
            // The section is reached once more at the end.
            let found = Side {
                is_changed: false,
                ..found
            };
            return Ok((found, Vec::from_iter(crosses.then_some(begin))));
        }
    }
    let is_smooth = corners.is_empty();
    let mut changes = match is_smooth && side.past.shows_all(value) {
        true => Vec::new(),
        false => {
            let points = side.past.points(last, (ends.clone(), corners), difference);
            changes(&points, side.sign)
        }
    };
    let inside = changes.last().map_or(side.sign, |(_, sign)| *sign);
    let mut other = side.after(value, value, sign(value, inside));
    // One change from the side before the step to that after it is between its ends. Where the step begins next to the surface,
    // only points within it tell a change from the beginning.
    let begins_off = is_off(side.past.value(), largest(&ends));
    let is_whole =
        is_smooth && changes.is_empty() || changes.len() == 1 && value != 0.0 && begins_off;
    if is_whole && other.is_changed {
        changes = vec![(ends, other.sign)];
    }
    other.is_changed = !changes.is_empty();
    let mut found = Vec::with_capacity(1);
    for (ends, sign) in changes {
        if !section.counts(sign) {
            continue;
        }
        let largest = largest(&ends);
        let ends = ends.map(|end| Between {
            value: end.value * sign,
            ..end
        });
        let mut rising = |_: &[f64], state: &[f64]| difference(state) * sign;
        let enough = Some(CLOSE * largest);
        let bracket = last
            .enclose(ends, &|v| v >= 0.0, enough, &mut rising)
            .map_err(Fault::Step)?;
        let nearest = bracket.nearest;
        if nearest.value.abs() <= JUMP * largest {
            found.push(nearest);
        }
    }
    Ok((other, found))
}
