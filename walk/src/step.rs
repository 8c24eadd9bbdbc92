//! States between the one before the last step and the one after it: ends of shorter steps from the first.

use std::borrow::Cow;

use leafwise_core::walk::column;
use leafwise_core::{Setting, StepError, StepMap, Stepper, Walk, two_sum};
use serde::{Deserialize, Serialize};

/// Steps that are tried for one that ends where a function of the state is zero.
pub(crate) const MOST_TRIED: usize = 100;

/// How near to each other two lengths of a step are that are not told apart, over the whole length.
pub(crate) const CLOSE: f64 = 4.0 * f64::EPSILON;

/// State before the last step, kept by a checkpoint; empty where no state between is asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepStart {
    /// x_{k−1}.
    pub state: Vec<f64>,
    /// Compensation of x_{k−1}: the part that a double does not hold.
    pub compensation: Vec<f64>,
    /// Of a lane that an event has changed within the step: the part of the step that came before, from where the states above begin.
    /// Empty where there is none.
    pub from: Vec<f64>,
}

/// The state of one lane after the last step.
pub struct StepEnd<'a> {
    /// x_k.
    pub state: Cow<'a, [f64]>,
    /// Compensation of x_k: the part that a double does not hold.
    pub compensation: Cow<'a, [f64]>,
}

impl<'a> StepEnd<'a> {
    /// Of a lane of a walk.
    pub fn of(walk: &'a Walk, lane: usize) -> Self {
        let own = |all: &'a [f64]| match walk.lanes() {
            1 => Cow::Borrowed(all),
            lanes => Cow::Owned(column(all, lane, lanes)),
        };
        Self {
            state: own(walk.state()),
            compensation: own(walk.compensation()),
        }
    }
}

impl StepStart {
    /// Keeps the states that the next step begins at, all lanes.
    pub fn keep(&mut self, walk: &Walk) {
        self.state.clear();
        self.state.extend_from_slice(walk.state());
        self.compensation.clear();
        self.compensation.extend_from_slice(walk.compensation());
        self.from.clear();
    }

    /// The part of the step at which a lane's states begin.
    pub fn from(&self, lane: usize) -> f64 {
        self.from.get(lane).copied().unwrap_or(0.0)
    }

    /// Lets a lane begin at another state after a part of the step.
    pub(crate) fn put(&mut self, lane: usize, lanes: usize, state: &[f64], from: f64) {
        for (at, value) in (lane..self.state.len()).step_by(lanes).zip(state) {
            (self.state[at], self.compensation[at]) = (*value, 0.0);
        }
        self.from.resize(lanes, 0.0);
        self.from[lane] = from;
    }
}

/// The last step of one trajectory, or what is left of it behind an event.
pub struct LastStep<'a> {
    map: &'a dyn StepMap,
    parameters: Vec<f64>,
    epsilon: f64,
    h: f64,
    /// Of shorter steps, once there was one.
    stepper: Option<Box<dyn Stepper>>,
    /// Where it begins.
    pub start: StepStart,
}

/// The end of a part of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Between {
    /// The step's length over that of the whole one: from 0 to 1.
    pub part: f64,
    /// The state.
    pub state: Vec<f64>,
    /// The value there of the function whose zero is looked for.
    pub value: f64,
}

/// Two ends of shorter steps about a zero, and the best one.
pub struct Bracket {
    /// The last end before it.
    pub before: Between,
    /// The first end behind it.
    pub behind: Between,
    /// The end where the function is nearest to zero.
    pub nearest: Between,
    /// Steps that were tried.
    pub tried: usize,
}

impl<'a> LastStep<'a> {
    /// No step yet of a map with these parameters and step sizes ε and h.
    pub fn new(map: &'a dyn StepMap, parameters: Vec<f64>, epsilon: f64, h: f64) -> Self {
        Self {
            map,
            parameters,
            epsilon,
            h,
            stepper: None,
            start: StepStart::default(),
        }
    }

    /// x_k − x_{k−1} in one coordinate.
    pub fn advance(&self, end: &StepEnd<'_>, coordinate: usize) -> f64 {
        (end.state[coordinate] - self.start.state[coordinate])
            + (end.compensation[coordinate] - self.start.compensation[coordinate])
    }

    /// Where t = k ε h advances by the same each step, the time after a part of the last one.
    pub fn time(&self, steps: u64, part: f64) -> f64 {
        ((steps - 1) as f64 + self.whole(part)) * (self.epsilon * self.h)
    }

    /// The part of the whole step that a part of what is left of it ends at.
    pub fn whole(&self, part: f64) -> f64 {
        let from = self.start.from(0);
        from + part * (1.0 - from)
    }

    /// The state at a time within the last step, where t = k ε h advances by the same each step.
    ///
    /// # Errors
    /// The [`StepError`] of the shorter step.
    pub fn state_at(&mut self, steps: u64, time: f64) -> Result<Vec<f64>, StepError> {
        let step = self.epsilon * self.h;
        let from = self.start.from(0);
        let part = (time - ((steps - 1) as f64 + from) * step) / (step * (1.0 - from));
        self.part(part.clamp(0.0, 1.0))
    }

    /// The state after a part of the last step.
    ///
    /// # Errors
    /// The [`StepError`] of the shorter step.
    pub fn part(&mut self, part: f64) -> Result<Vec<f64>, StepError> {
        let increment = self.increment(part)?;
        Ok(self.sum(&increment))
    }

    /// The beginning and the end of the step, where a function has these values.
    pub fn ends(&self, end: &[f64], values: [f64; 2]) -> [Between; 2] {
        let between = |part: f64, state: &[f64], value: f64| Between {
            part,
            state: state.to_vec(),
            value,
        };
        [
            between(0.0, &self.start.state, values[0]),
            between(1.0, end, values[1]),
        ]
    }

    /// Encloses the place where `value`, a function of the increment and of the state, rises through zero between two places
    /// in the last step. The sequence of steps goes on undisturbed.
    ///
    /// The search ends where the value is at most `enough`, if that is given, or where the lengths of steps are not
    /// told apart any more. A part s of the step is read off the polynomial s(value) through all values that are known.
    /// Where that does not halve the bracket, the next one lies a little beyond the nearer end.
    ///
    /// # Errors
    /// The [`StepError`] of a shorter step.
    pub fn enclose(
        &mut self,
        [before, behind]: [Between; 2],
        is_behind: &dyn Fn(f64) -> bool,
        enough: Option<f64>,
        value: &mut dyn FnMut(&[f64], &[f64]) -> f64,
    ) -> Result<Bracket, StepError> {
        let mut known = vec![(before.value, before.part), (behind.value, behind.part)];
        let is_nearer = before.value.abs() < behind.value.abs();
        let mut bracket = Bracket {
            nearest: if is_nearer { &before } else { &behind }.clone(),
            before,
            behind,
            tried: 0,
        };
        known.retain(|(value, _)| value.is_finite());
        let mut beyond = CLOSE;
        while bracket.tried < MOST_TRIED {
            let (least, most) = (bracket.before.part, bracket.behind.part);
            let width = most - least;
            let is_enough = enough.is_some_and(|enough| bracket.nearest.value.abs() <= enough);
            if is_enough || width <= CLOSE {
                break;
            }
            let read = inverse(&known);
            let is_inside = read >= least && read <= most && width > 2.0 * beyond;
            let part = match is_inside {
                true => read.max(least + beyond).min(most - beyond),
                false => 0.5 * (least + most),
            };
            let increment = self.increment(part)?;
            let state = self.sum(&increment);
            let found = value(&increment, &state);
            bracket.tried += 1;
            let tried = Between {
                part,
                state,
                value: found,
            };
            if found.abs() < bracket.nearest.value.abs() {
                bracket.nearest = tried.clone();
            }
            if found.is_finite() {
                known.push((found, part));
            }
            *(match is_behind(found) {
                true => &mut bracket.behind,
                false => &mut bracket.before,
            }) = tried;
            let is_halved = bracket.behind.part - bracket.before.part <= 0.5 * width;
            beyond = if is_halved { CLOSE } else { 8.0 * beyond };
        }
        Ok(bracket)
    }

    /// Of a step that cannot be taken as a whole, a part that can and at whose end the state is one that is looked for,
    /// with that state. Parts are halved towards the longest one that can be taken.
    pub fn reached(&mut self, mut is_it: impl FnMut(&[f64]) -> bool) -> Option<(f64, Vec<f64>)> {
        let (mut least, mut most) = (0.0, 1.0);
        for _ in 0..MOST_TRIED {
            if most - least <= CLOSE {
                break;
            }
            let part = 0.5 * (least + most);
            match self.part(part) {
                Ok(state) if is_it(&state) => return Some((part, state)),
                Ok(_) => least = part,
                Err(_) => most = part,
            }
        }
        None
    }

    /// A look at a part of the last step as if it were the whole one.
    pub fn within<T>(&mut self, part: f64, look: impl FnOnce(&mut Self) -> T) -> T {
        let whole = self.h;
        (self.h, self.stepper) = (part * whole, None);
        let seen = look(self);
        (self.h, self.stepper) = (whole, None);
        seen
    }

    /// The increment over a part of the last step. The stepper knows nothing of earlier ones.
    fn increment(&mut self, part: f64) -> Result<Vec<f64>, StepError> {
        let h = self.h * (1.0 - self.start.from(0)) * part;
        let is_ready = self
            .stepper
            .as_mut()
            .is_some_and(|stepper| stepper.set(Setting::StepSize(h)));
        if !is_ready {
            self.stepper = None;
        }
        let make = || self.map.stepper(1, &self.parameters, self.epsilon, h);
        let stepper = self.stepper.get_or_insert_with(make);
        let mut increment = vec![0.0; self.start.state.len()];
        let mut outcome = [Ok(())];
        let (state, low) = (&self.start.state, &self.start.compensation);
        stepper.increment(state, low, &mut increment, &mut outcome);
        let [outcome] = outcome;
        outcome.map(|()| increment)
    }

    /// The state before the last step and an increment.
    fn sum(&self, increment: &[f64]) -> Vec<f64> {
        let (state, low) = (&self.start.state, &self.start.compensation);
        let sums = state.iter().zip(low).zip(increment);
        sums.map(|((x, low), change)| two_sum(*x, change + low).0)
            .collect()
    }
}

/// The polynomial s(v) through the known values, at v = 0, by Neville's scheme.
fn inverse(known: &[(f64, f64)]) -> f64 {
    let mut values: Vec<f64> = known.iter().map(|(_, part)| *part).collect();
    for width in 1..known.len() {
        for at in 0..known.len() - width {
            let (left, right) = (known[at].0, known[at + width].0);
            let (a, b) = (values[at], values[at + 1]);
            values[at] = (left * b - right * a) / (left - right);
        }
    }
    values.first().copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::inverse;

    #[test]
    fn a_polynomial_is_inverted_where_it_is_known() {
        // s = t³ through four values, read at t = 0.75.
        let known: Vec<(f64, f64)> = [0.0, 1.0, 0.25, 0.5]
            .map(|t: f64| (t - 0.75, t * t * t))
            .to_vec();
        assert!((inverse(&known) - 0.421_875).abs() < 1e-15);
    }
}
