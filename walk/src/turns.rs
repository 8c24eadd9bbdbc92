//! Turns of a function of the state within a step, by which it changes its sign and back unseen from the step's ends.
//!
//! Over a step of length 1 let |g''| ≤ M. Then g is monotone where |g(1) − g(0)| ≥ M/2. Where both ends are positive it stays
//! so if the parabola g(0) + (g(1) − g(0)) s − M s (1 − s)/2 does. Other steps are bisected by shorter steps, and M falls with
//! the square of the length. M is read off second differences of g over the steps before.

use serde::{Deserialize, Serialize};

use crate::functions::FunctionValues;
use crate::step::{Between, LastStep, MOST_TRIED};

/// How much more a function may bend within a step than over the steps around it.
const SAFETY: f64 = 4.0;

/// The part of a step beside a corner at which its sides are looked at: nearer, round-off decides of the side.
const BESIDE: f64 = 1e-10;

/// The part of the largest value in a step up to which a value within it is a contact with zero, no change of sign.
const CONTACT: f64 = 1e-8;

/// Values of a function after the last steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Past {
    /// The steps that were made by then.
    steps: u64,
    /// The steps behind which values follow one another over equal steps.
    since: u64,
    /// After the last step but one.
    before: f64,
    /// After the last step.
    last: f64,
    /// Its second difference there, without sign.
    bend: f64,
}

impl Past {
    /// At the initial state.
    pub fn begin(value: f64) -> Self {
        Self {
            last: value,
            ..Self::default()
        }
    }

    /// Within the next step, where an event has changed the state: what was before says nothing of what follows.
    #[must_use]
    pub(crate) fn begun_again(self, value: f64) -> Self {
        Self {
            steps: self.steps,
            since: self.steps + 1,
            ..Self::begin(value)
        }
    }

    /// How many equal steps lead from one value to the next.
    fn equal_steps(&self) -> u64 {
        self.steps.saturating_sub(self.since)
    }

    /// The value after the last step.
    pub fn value(&self) -> f64 {
        self.last
    }

    /// Whether the value after so many steps is among them.
    pub fn has_seen(&self, steps: u64) -> bool {
        steps <= self.steps
    }

    /// After one more step.
    #[must_use]
    pub fn then(self, value: f64) -> Self {
        Self {
            steps: self.steps + 1,
            since: self.since,
            before: self.last,
            last: value,
            bend: self.bend_to(value),
        }
    }

    fn bend_to(&self, value: f64) -> f64 {
        match self.equal_steps() {
            0 => 0.0,
            _ => (value - 2.0 * self.last + self.before).abs(),
        }
    }

    /// M in the next step, which ends at this value. Infinite where nothing is known of it.
    fn most_bent(&self, value: f64) -> f64 {
        match self.equal_steps() {
            // One second difference alone may be near a point of inflection.
            0 | 1 => f64::INFINITY,
            _ => SAFETY * self.bend_to(value).max(self.bend),
        }
    }

    /// Whether the ends of the next step, of which the second has this value, show every change of sign in it.
    pub fn shows_all(&self, value: f64) -> bool {
        shows_all([self.last, value], self.most_bent(value))
    }

    /// The beginning and the end of the next step, and states between them where it turns. From one to the next there is one
    /// change of sign at most. `corners` are both sides of the places where it is not smooth.
    pub(crate) fn points(
        &self,
        last: &mut LastStep<'_>,
        ([begin, end], corners): ([Between; 2], Vec<[Between; 2]>),
        difference: &mut dyn FnMut(&[f64]) -> f64,
    ) -> Vec<Between> {
        // Steps before say nothing of what is beside a corner.
        let most = match corners.is_empty() {
            true => self.most_bent(end.value),
            false => f64::INFINITY,
        };
        let mut points = Points {
            last,
            difference,
            largest: begin.value.abs().max(end.value.abs()),
            found: vec![begin],
            tried: 0,
        };
        for [before, behind] in corners {
            points.up_to(before, most);
            points.found.push(behind);
        }
        points.up_to(end, most);
        points.found
    }
}

/// Both sides of each place in the last step where a function from number `first` on changes its sign. They stand in the order of
/// the places, with the values of the first function. `pasts` are those of the functions from number `first` on.
pub(crate) fn corners(
    last: &mut LastStep<'_>,
    ends: &[Between; 2],
    values: &mut FunctionValues,
    (first, pasts): (usize, &[Past]),
) -> Vec<[Between; 2]> {
    let at_end = values.at(&ends[1].state).to_vec();
    let mut found: Vec<[Between; 2]> = Vec::new();
    // Parts of a formula stand behind it: a corner turns abruptly where a part of it has one.
    for (number, past) in (first..at_end.len()).zip(pasts).rev() {
        let (begins, behind) = (past.value(), at_end[number]);
        // False where a value is no number.
        let is_crossed = begins * behind < 0.0;
        let is_undefined = (begins * behind).is_nan();
        let shows_all = past.shows_all(behind) && found.is_empty();
        if !is_crossed && (shows_all || is_undefined) {
            continue;
        }
        let [begin, end] = ends.clone();
        let whole = [begin, end].map(|end| valued(end, values, number));
        let mut places = Vec::new();
        if !shows_all {
            let inner = found.iter().cloned();
            let inner = inner.map(|sides| sides.map(|side| valued(side, values, number)));
            let inner: Vec<_> = inner.collect();
            let at = &mut |state: &[f64]| values.at(state)[number];
            let points = past.points(last, (whole.clone(), inner), at);
            places = changes(&points, sign(begins, 0.0));
        }
        if is_crossed && places.len() <= 1 {
            places = vec![(whole, sign(behind, 0.0))];
        }
        let own = places
            .into_iter()
            .filter_map(|place| sides(last, ends, values, (number, place)));
        found.extend(own.collect::<Vec<_>>());
        found.sort_by(|[one, _], [other, _]| one.part.total_cmp(&other.part));
    }
    found
}

/// A place in a step with the value of another function.
fn valued(place: Between, values: &mut FunctionValues, number: usize) -> Between {
    Between {
        value: values.at(&place.state)[number],
        ..place
    }
}

/// Both sides of a place between two at which the function of a number changes its sign, with the values of the first function.
fn sides(
    last: &mut LastStep<'_>,
    ends: &[Between; 2],
    values: &mut FunctionValues,
    (number, (places, sign)): (usize, Change),
) -> Option<[Between; 2]> {
    let places = places.map(|place| Between {
        value: place.value * sign,
        ..place
    });
    let mut rising = |_: &[f64], state: &[f64]| values.at(state)[number] * sign;
    // Where a part of the step cannot be taken, its ends show what is known.
    let bracket = last.enclose(places, &|value| value >= 0.0, None, &mut rising);
    let bracket = bracket.ok()?;
    let (before, behind) = (bracket.before.part - BESIDE, bracket.behind.part + BESIDE);
    let [begin, end] = ends.clone();
    let sides =
        [(before, begin), (behind, end)].map(|(part, known)| match part > 0.0 && part < 1.0 {
            true => last.part(part).map(|state| Between {
                part,
                value: values.at(&state)[0],
                state,
            }),
            false => Ok(known),
        });
    match sides {
        [Ok(before), Ok(behind)] => Some([before, behind]),
        _ => None,
    }
}

/// Whether values at the two ends of a step show every change of sign in it.
fn shows_all([left, right]: [f64; 2], most: f64) -> bool {
    let change = right - left;
    if !change.is_finite() || change.abs() >= 0.5 * most {
        return true;
    }
    if left * right <= 0.0 {
        return false;
    }
    let (left, right) = (left.abs(), right.abs());
    let lowest = 0.5 - (right - left) / most;
    left - 0.5 * most * lowest * lowest > 0.0
}

/// The largest value at points.
pub(crate) fn largest(points: &[Between]) -> f64 {
    let sizes = points.iter().map(|point| point.value.abs());
    sizes.filter(|size| size.is_finite()).fold(0.0, f64::max)
}

/// Whether a value within a step, of which the largest is given, is no mere contact with zero.
pub(crate) fn is_off(value: f64, largest: f64) -> bool {
    value.abs() > CONTACT * largest
}

/// Points found so far, from the beginning of a step on.
struct Points<'a, 'b> {
    last: &'a mut LastStep<'b>,
    difference: &'a mut dyn FnMut(&[f64]) -> f64,
    found: Vec<Between>,
    /// The largest value known.
    largest: f64,
    tried: usize,
}

impl Points<'_, '_> {
    /// From the last point to the next one that is known, over which |g''| is at most this, that length being 1.
    fn up_to(&mut self, next: Between, most: f64) {
        let from = &self.found[self.found.len() - 1];
        let (left, right) = (from.value, next.value);
        // Turns that come no further than a contact are not looked for.
        let is_flat = most <= 8.0 * CONTACT * self.largest;
        if !is_flat && self.tried < MOST_TRIED && !shows_all([left, right], most) {
            let part = f64::midpoint(from.part, next.part);
            self.tried += 1;
            // A shorter step that cannot be taken shows nothing more.
            if let Ok(state) = self.last.part(part) {
                let value = (self.difference)(&state);
                self.largest = self.largest.max(value.abs());
                let bend = SAFETY * (left - 2.0 * value + right).abs();
                let half = match most.is_finite() {
                    true => bend.clamp(most / 16.0, most / 4.0),
                    false => bend,
                };
                let middle = Between { part, state, value };
                self.up_to(middle, half);
                self.up_to(next, half);
                return;
            }
        }
        self.found.push(next);
    }
}

/// Two places in a step between which a function changes its sign, and the sign behind.
pub(crate) type Change = ([Between; 2], f64);

/// The changes of sign between points of a step, from the first to the last. The first point is on the side with this sign.
/// Contacts with zero within the step have no sign, as the last point where it is zero.
pub(crate) fn changes(points: &[Between], first: f64) -> Vec<Change> {
    let largest = largest(points);
    let mut found = Vec::new();
    let Some((begin, rest)) = points.split_first() else {
        return found;
    };
    let (mut from, mut side) = (begin, first);
    for (point, left) in rest.iter().zip((0..rest.len()).rev()) {
        let is_signed = match left {
            0 => point.value != 0.0,
            _ => is_off(point.value, largest),
        };
        if !is_signed {
            continue;
        }
        let own = sign(point.value, side);
        if own * side < 0.0 {
            found.push(([from.clone(), point.clone()], own));
        }
        (from, side) = (point, own);
    }
    found
}

/// The sign of a value, and what stands for it where that is zero.
pub(crate) fn sign(value: f64, zero: f64) -> f64 {
    if value == 0.0 {
        zero
    } else {
        1.0_f64.copysign(value)
    }
}

#[cfg(test)]
mod tests {
    use super::{Past, shows_all};

    /// sin(ω k + φ) − c over steps so long that a period takes hardly three: where the ends of a step show no change of sign
    /// and are said to show all, there is none, by the highest point of the sine.
    #[test]
    fn no_turn_of_a_sine_past_zero_is_passed_over() {
        let mut hidden = 0;
        for (omega, phases) in [(0.05, 400), (0.7, 300), (1.3, 300), (2.0, 300)] {
            for (phase, at) in (0..phases).map(|k| f64::from(k) * 0.021).zip(0..) {
                let level = [0.9999, 0.95, 0.8, 0.5, -0.9][at % 5];
                let value = |k: u32| libm::sin(omega * f64::from(k) + phase) - level;
                let mut past = Past::begin(value(0));
                for k in 1..20 {
                    let (from, to) = (
                        omega * f64::from(k - 1) + phase,
                        omega * f64::from(k) + phase,
                    );
                    let turns = |top: f64| {
                        let period = core::f64::consts::TAU;
                        libm::ceil((from - top) / period) * period + top < to
                    };
                    let quarter = core::f64::consts::FRAC_PI_2;
                    let (before, after) = (value(k - 1), value(k));
                    let is_hidden = before * after > 0.0
                        && (before < 0.0 && turns(quarter) || before > 0.0 && turns(-quarter));
                    if is_hidden {
                        hidden += 1;
                        assert!(!past.shows_all(after), "{omega} {phase} {level} {k}");
                    }
                    past = past.then(after);
                }
            }
        }
        assert!(hidden > 500, "{hidden}");
    }

    /// Of fine steps nearly all show all there is to see: nothing is spent on them.
    #[test]
    fn fine_steps_are_hardly_ever_looked_into() {
        let value = |k: u32| libm::sin(0.01 * f64::from(k)) - 0.5;
        let mut past = Past::begin(value(0));
        let mut looks = 0;
        for k in 1..100_000 {
            looks += u32::from(!past.shows_all(value(k)));
            past = past.then(value(k));
        }
        // The first two steps, of which too little is known.
        assert_eq!(looks, 2);
    }

    /// A parabola of second derivative M that touches zero is the bound itself.
    #[test]
    fn the_bound_is_that_of_a_parabola() {
        for at in [0.1, 0.25, 0.5, 0.8] {
            let most = 3.0;
            let value = |s: f64, deep: f64| 0.5 * most * (s - at) * (s - at) - deep;
            for deep in [1e-9, -1e-9] {
                let ends = [value(0.0, deep), value(1.0, deep)];
                let is_hidden = deep > 0.0;
                assert_eq!(shows_all(ends, most), !is_hidden, "{at} {deep}");
                assert_eq!(shows_all(ends.map(|v| -v), most), !is_hidden, "{at} {deep}");
            }
        }
    }
}
