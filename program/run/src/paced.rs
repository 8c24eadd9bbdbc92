//! Steps of a fictitious time: their times, and states at given times between them.

use leafwise_core::runge_kutta::SmoothMapEvaluator;
use leafwise_core::system::SystemObservables;
use leafwise_core::{BuildError, Evaluator, Integrator, Observe, StepError, two_sum};
use leafwise_scene::compose::{ComposedRun, Pace};
use serde::{Deserialize, Serialize};

use super::outcome::Failure;

/// What a checkpoint keeps beside the state; empty where steps are of the time itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PacedSteps {
    /// min |t_{k+1} − t_k|.
    pub least: f64,
    /// max |t_{k+1} − t_k|.
    pub most: f64,
    /// x_{k−1} of the last step.
    pub state: Vec<f64>,
    /// What x_{k−1} holds beyond a double.
    pub compensation: Vec<f64>,
    /// The time at the last look whether it advances.
    pub seen: f64,
}

/// The pace of a run at its steps.
pub(super) struct Paced<'a> {
    run: &'a ComposedRun,
    pace: &'a Pace,
    /// g and H + e.
    observer: SystemObservables,
    /// ∇K.
    gradient: Option<SmoothMapEvaluator>,
    parameters: Vec<f64>,
    pub steps: PacedSteps,
}

/// Steps over which the time has to advance, though single ones may be as short as they like.
const LOOKED_OVER: u64 = 1 << 16;

/// The least part of the way to the end that it advances by then: a run of 10¹² steps comes there in days.
const STALLED: f64 = 1e-7;

/// The part of |e| below which no balance H + e is looked at.
const NEGLIGIBLE: f64 = 1e-6;

/// The part of ∇K that (H + e)∇g may be.
const MOST_FALSE: f64 = 0.1;

/// The part of itself that a state may be moved by (H + e)∇g in one step.
const MOST_MOVED: f64 = 1e-3;

/// Steps that are tried for one that ends at a given time.
const MOST_TRIED: usize = 24;

/// Roundings of a time that it may be missed by: the length of a step is rounded too.
const MISSED: f64 = 64.0;

/// Coordinates that a message shows.
const SHOWN: usize = 6;

impl<'a> Paced<'a> {
    /// `None` where a run's steps are of the time itself.
    pub fn of(run: &'a ComposedRun) -> Result<Option<Self>, BuildError> {
        let extension = run.extension.as_ref();
        let Some((extension, pace)) = extension.and_then(|of| Some((of, of.pace.as_ref()?))) else {
            return Ok(None);
        };
        let parameters = run.system.parameter_values();
        let watched = [&pace.formula, extension.energy()];
        let observer = SystemObservables::new(&run.system, &watched, &parameters)?;
        let gradient = run.system.gradient_values().ok();
        let gradient = gradient.map(|map| map.evaluator(&parameters, 1.0, 1.0));
        let initial = &run.plan.initial;
        Ok(Some(Self {
            run,
            pace,
            observer,
            gradient,
            parameters,
            steps: PacedSteps {
                least: 0.0,
                most: 0.0,
                state: initial.clone(),
                compensation: vec![0.0; initial.len()],
                seen: 0.0,
            },
        }))
    }

    /// Where t stands in a state.
    fn place(&self) -> usize {
        self.run.own(&self.run.plan.initial).len()
    }

    /// The time of the present state.
    pub fn time(&self, integrator: &Integrator) -> f64 {
        integrator.state()[self.place()]
    }

    /// Whether one time comes before another on the run's way.
    pub fn is_before(&self, time: f64, other: f64) -> bool {
        let forward = self.run.plan.epsilon * self.run.plan.h;
        (other - time) * forward > 0.0
    }

    /// The time of the sample with this number, where samples lie at given times.
    pub fn time_of_sample(&self, number: u64) -> Option<f64> {
        let forward = self.run.plan.epsilon * self.run.plan.h;
        let interval = self.run.plan.interval?;
        let time = number as f64 * interval.copysign(forward);
        // The end itself is recorded as the end.
        let is_end = |until: f64| (until - time).abs() <= MISSED * f64::EPSILON * until.abs();
        let is_ahead = |until: f64| self.is_before(time, until) && !is_end(until);
        self.run.plan.until.is_none_or(is_ahead).then_some(time)
    }

    /// Keeps the state that the next step begins at.
    pub fn keep(&mut self, integrator: &Integrator) {
        self.steps.state.copy_from_slice(integrator.state());
        let low = integrator.compensation();
        self.steps.compensation.copy_from_slice(low);
    }

    /// Takes in the step that was made; why the run cannot go on from there, if it cannot.
    pub fn take(&mut self, integrator: &Integrator) -> Option<Failure> {
        let t = self.place();
        let before = self.steps.state[t];
        let mut values = [0.0; 2];
        self.observer.evaluate(integrator.state(), &mut values);
        let [value, balance] = values;
        let advance = self.advance(integrator);
        let forward = self.run.plan.epsilon * self.run.plan.h;
        let pace = self.pace.text.as_str();
        let message = if !(value > 0.0 && value.is_finite()) {
            let own = self.run.names().into_iter().zip(integrator.state());
            let place: Vec<String> = own
                .take(SHOWN)
                .map(|(name, x)| format!("{name} = {x:?}"))
                .collect();
            let place = place.join(", ");
            format!(
                "the pace {pace} must be positive, and is {value:?} after this step, at {place}"
            )
        } else if advance * forward < 0.0 {
            format!(
                "the time goes from t = {before:?} the other way, by {advance:e}: the step is too long for the pace {pace}"
            )
        } else if advance == 0.0 || self.stalls(integrator) {
            format!(
                "the pace {pace} stalls: it is {value:e}, and this step advances t by {advance:e}"
            )
        } else if self.is_lost(integrator.state(), balance) {
            format!(
                "the pace {pace} is so near to 0, {value:e}, that the error {balance:e} of the energy, K/pace, moves the state: \
                 it turns back where it should go on"
            )
        } else {
            let size = advance.abs();
            let is_first = self.steps.most == 0.0;
            self.steps.least = if is_first {
                size
            } else {
                size.min(self.steps.least)
            };
            self.steps.most = size.max(self.steps.most);
            return None;
        };
        let state = self.run.own(&self.steps.state);
        Some(Failure {
            message,
            step: integrator.steps(),
            time: before,
            state: state.to_vec(),
            hint: "write a pace that is positive along the motion, or reduce epsilon*h".to_owned(),
        })
    }

    /// Whether (H + e)∇g, which is 0 on the motion, makes a part of ∇K = g∇H + (H + e)∇g that shows in the state.
    ///
    /// ∇g is taken by central differences; an error of the balance below [`NEGLIGIBLE`] is not looked at.
    fn is_lost(&mut self, state: &[f64], balance: f64) -> bool {
        let energy = state[self.place() + 1].abs();
        if balance.abs() <= NEGLIGIBLE * energy {
            return false;
        }
        let Some(gradient) = &mut self.gradient else {
            return false;
        };
        let mut whole = vec![0.0; state.len()];
        if gradient.values(state, &mut whole).is_err() {
            return false;
        }
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let own = self.run.own(state).len();
        let size = largest(&state[..own]);
        let mut near = state.to_vec();
        let mut slopes = vec![0.0; own];
        for (at, slope) in slopes.iter_mut().enumerate() {
            let width = libm::cbrt(f64::EPSILON) * size;
            let mut value = |x: f64| {
                near[at] = x;
                let mut values = [0.0; 2];
                self.observer.evaluate(&near, &mut values);
                values[0]
            };
            let (above, below) = (value(state[at] + width), value(state[at] - width));
            value(state[at]);
            *slope = (above - below) / (2.0 * width);
        }
        let part = balance.abs() * largest(&slopes);
        let step = (self.run.plan.epsilon * self.run.plan.h).abs();
        part > MOST_FALSE * largest(&whole[..own]) && part * step > MOST_MOVED * size
    }

    /// Whether the time has hardly advanced since the last look.
    fn stalls(&mut self, integrator: &Integrator) -> bool {
        if !integrator.steps().is_multiple_of(LOOKED_OVER) {
            return false;
        }
        let time = self.time(integrator);
        let seen = std::mem::replace(&mut self.steps.seen, time);
        let left = self
            .run
            .plan
            .until
            .map_or(0.0, |until| (until - time).abs());
        (time - seen).abs() <= f64::max(STALLED * left, f64::EPSILON * time.abs())
    }

    /// t_{k+1} − t_k of the last step.
    fn advance(&self, integrator: &Integrator) -> f64 {
        let t = self.place();
        let (state, low) = (integrator.state(), integrator.compensation());
        (state[t] - self.steps.state[t]) + (low[t] - self.steps.compensation[t])
    }

    /// The state at `time`, between the state before the last step and the one after it: the end of a shorter step from
    /// there, whose length is solved for. The sequence of steps goes on undisturbed.
    ///
    /// t(s) over the parts s of a step rises; s is read off the polynomial s(t) through all values that are known.
    pub fn state_at(&self, integrator: &Integrator, time: f64) -> Result<Vec<f64>, StepError> {
        let t = self.place();
        let (state, low) = (&self.steps.state, &self.steps.compensation);
        let wanted = (time - state[t]) - low[t];
        let whole = self.advance(integrator);
        if wanted == 0.0 {
            return Ok(state.clone());
        }
        if wanted == whole {
            return Ok(integrator.state().to_vec());
        }
        let rounding = f64::EPSILON * time.abs().max(whole.abs());
        let mut known = vec![(0.0, 0.0), (whole, 1.0)];
        let (mut least, mut most) = (0.0, 1.0);
        let mut nearest: Option<(f64, Vec<f64>)> = None;
        for _ in 0..MOST_TRIED {
            let read = inverse(&known, wanted);
            let is_inside = read > least && read < most;
            let part = if is_inside {
                read
            } else {
                0.5 * (least + most)
            };
            let increment = self.increment(part)?;
            let missed = increment[t] - wanted;
            let (is_over, found) = ((missed > 0.0) == (whole > 0.0), increment[t]);
            if nearest
                .as_ref()
                .is_none_or(|(before, _)| missed.abs() < *before)
            {
                nearest = Some((missed.abs(), increment));
            }
            if missed.abs() <= 0.5 * rounding || most - least <= f64::EPSILON {
                break;
            }
            *(if is_over { &mut most } else { &mut least }) = part;
            known.push((found, part));
        }
        match nearest {
            Some((missed, increment)) if missed <= MISSED * rounding => {
                let sums = state.iter().zip(low).zip(&increment);
                Ok(sums
                    .map(|((x, low), change)| two_sum(*x, change + low).0)
                    .collect())
            }
            nearest => Err(StepError::NoConvergence {
                evaluations: MOST_TRIED,
                correction: nearest.map_or(f64::NAN, |(missed, _)| missed / whole.abs()),
            }),
        }
    }

    /// The increment over a part of the last step.
    fn increment(&self, part: f64) -> Result<Vec<f64>, StepError> {
        let (plan, map) = (&self.run.plan, self.run.method.map());
        let mut stepper = map.stepper(1, &self.parameters, plan.epsilon, plan.h * part);
        let mut increment = vec![0.0; self.steps.state.len()];
        let mut outcome = [Ok(())];
        let (state, low) = (&self.steps.state, &self.steps.compensation);
        stepper.increment(state, low, &mut increment, &mut outcome);
        let [outcome] = outcome;
        outcome.map(|()| increment)
    }
}

/// The polynomial s(t) through the known values, by Neville's scheme.
fn inverse(known: &[(f64, f64)], wanted: f64) -> f64 {
    let mut values: Vec<f64> = known.iter().map(|(_, part)| *part).collect();
    for width in 1..known.len() {
        for at in 0..known.len() - width {
            let (left, right) = (known[at].0, known[at + width].0);
            let (a, b) = (values[at], values[at + 1]);
            values[at] = ((wanted - right) * a - (wanted - left) * b) / (left - right);
        }
    }
    values[0]
}

#[cfg(test)]
mod tests {
    use super::inverse;

    #[test]
    fn a_polynomial_is_inverted_where_it_is_known() {
        // s = t³ through four values.
        let known: Vec<(f64, f64)> = [0.0, 1.0, 0.25, 0.5].map(|t: f64| (t, t * t * t)).to_vec();
        assert!((inverse(&known, 0.75) - 0.421_875).abs() < 1e-15);
    }
}
