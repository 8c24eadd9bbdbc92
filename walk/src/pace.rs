//! Steps of a fictitious time: their times, and states at given times between them.

use leafwise_core::runge_kutta::SmoothMapEvaluator;
use leafwise_core::{BuildError, Evaluator, PoissonSystem, StepError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::functions::{FunctionValues, StateFunctions};
use crate::layout::Clock;
use crate::step::{LastStep, StepEnd};

/// g = dt/dτ, where steps are of a fictitious time τ and the time is a coordinate.
#[derive(Clone)]
pub struct Pace {
    /// The formula as it is written.
    pub text: String,
    /// Where t and its energy stand in a state.
    pub clock: Clock,
    /// g and H + e.
    pub watched: StateFunctions,
    /// The system of K = (H + e) g.
    pub system: PoissonSystem,
    /// Names of the coordinates before t, for messages.
    pub names: Vec<String>,
}

/// Why a walk cannot go on by its pace.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoPace {
    /// g is not positive.
    #[error("the pace {pace} must be positive, and is {value:?} after this step, at {place}")]
    NotPositive {
        /// The formula.
        pace: String,
        /// g.
        value: f64,
        /// The first coordinates, with their names.
        place: String,
    },
    /// The time goes back.
    #[error(
        "the time goes from t = {time:?} the other way, by {advance:e}: the step is too long for the pace {pace}"
    )]
    Backwards {
        /// The formula.
        pace: String,
        /// t before the step.
        time: f64,
        /// The change of t.
        advance: f64,
    },
    /// The time does not advance any more.
    #[error("the pace {pace} stalls: it is {value:e}, and this step advances t by {advance:e}")]
    Stalls {
        /// The formula.
        pace: String,
        /// g.
        value: f64,
        /// The change of t.
        advance: f64,
    },
    /// Ever more steps lead to no end.
    #[error(
        "the pace {pace} becomes too small to come to the end: it is {value:e} at t = {time:?}, and twice as many steps \
         advance t by {advance:e}"
    )]
    InVain {
        /// The formula.
        pace: String,
        /// g.
        value: f64,
        /// t.
        time: f64,
        /// The change of t over the last half of the steps.
        advance: f64,
    },
    /// The error of K moves the state.
    #[error(
        "the pace {pace} is so near to 0, {value:e}, that the error {balance:e} of the energy, K/pace, moves the state: \
         it turns back where it should go on"
    )]
    Lost {
        /// The formula.
        pace: String,
        /// g.
        value: f64,
        /// H + e.
        balance: f64,
    },
}

/// Times of the steps so far, kept by a checkpoint beside the states; zeros where steps are of the time itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PacedSteps {
    /// min |t_{k+1} − t_k|.
    pub least: f64,
    /// max |t_{k+1} − t_k|.
    pub most: f64,
    /// The time at the last look whether it advances.
    pub seen: f64,
    /// The time when the number of steps was last a power of two, and by how much it had then advanced since the one before.
    pub doubled: f64,
    /// That advance.
    pub advance: f64,
    /// How often in a row that advance had not grown.
    pub slower: u32,
}

/// The pace of one lane.
pub(crate) struct PaceWatch<'a> {
    pace: &'a Pace,
    parameters: Vec<f64>,
    /// ε h.
    step: f64,
    /// The time at the end.
    until: Option<f64>,
    /// g and H + e.
    watched: FunctionValues,
    /// ∇K, once it is asked for.
    gradient: Option<SmoothMapEvaluator>,
    pub steps: PacedSteps,
}

/// Steps over which the time has to advance, though single ones may be as short as they like.
const LOOKED_OVER: u64 = 1 << 16;

/// The least part of the way to the end that it advances by then: a run of 10¹² steps comes there in days.
const STALLED: f64 = 1e-7;

/// Steps from which on their number is looked at when it doubles.
const LEAST_DOUBLED: u64 = 1 << 12;

/// Doublings in a row, by each of which the time advances by no more than by that before: a steady motion advances by twice
/// as much.
const SLOWER: u32 = 4;

/// The most doublings from the first step to the end: 2⁴² steps take months.
const MOST_DOUBLINGS: f64 = 42.0;

/// The part of |e| below which no balance H + e is looked at.
const NEGLIGIBLE: f64 = 1e-6;

/// The part of ∇K that (H + e)∇g may be.
const MOST_FALSE: f64 = 0.1;

/// The part of itself that a state may be moved by (H + e)∇g in one step.
const MOST_MOVED: f64 = 1e-3;

/// Roundings of a time that it may be missed by: the length of a step is rounded too.
const MISSED: f64 = 64.0;

/// Coordinates that a message shows.
const SHOWN: usize = 6;

impl Pace {
    /// t of a state.
    pub fn time_at(&self, state: &[f64]) -> f64 {
        state[self.clock.time]
    }
}

impl<'a> PaceWatch<'a> {
    /// The pace at one lane's parameters; ε h is the `step`, `until` the time at the end.
    pub fn new(
        pace: &'a Pace,
        parameters: Vec<f64>,
        step: f64,
        until: Option<f64>,
    ) -> Result<Self, BuildError> {
        Ok(Self {
            watched: pace.watched.values(1, &parameters)?,
            pace,
            parameters,
            step,
            until,
            gradient: None,
            steps: PacedSteps::default(),
        })
    }

    /// Takes in the last of so many steps; why the walk cannot go on from there, if it cannot.
    pub fn take(&mut self, last: &LastStep<'_>, end: &StepEnd<'_>, steps: u64) -> Option<NoPace> {
        let t = self.pace.clock.time;
        let time = last.start.state[t];
        let values = self.watched.at(&end.state);
        let (value, balance) = (values[0], values[1]);
        let advance = last.advance(end, t);
        let pace = || self.pace.text.clone();
        let is_backwards = advance * self.step < 0.0;
        if !(value > 0.0 && value.is_finite()) {
            let own = self.pace.names.iter().zip(&*end.state);
            let place: Vec<String> = own
                .take(SHOWN)
                .map(|(name, x)| format!("{name} = {x:?}"))
                .collect();
            return Some(NoPace::NotPositive {
                pace: pace(),
                value,
                place: place.join(", "),
            });
        }
        if is_backwards {
            return Some(NoPace::Backwards {
                pace: pace(),
                time,
                advance,
            });
        }
        if advance == 0.0 || self.stalls(&end.state, steps) {
            return Some(NoPace::Stalls {
                pace: self.pace.text.clone(),
                value,
                advance,
            });
        }
        if self.is_in_vain(&end.state, steps) {
            return Some(NoPace::InVain {
                pace: self.pace.text.clone(),
                value,
                time: self.pace.time_at(&end.state),
                advance: self.steps.advance,
            });
        }
        if self.is_lost(&end.state, balance) {
            return Some(NoPace::Lost {
                pace: self.pace.text.clone(),
                value,
                balance,
            });
        }
        let size = advance.abs();
        let is_first = self.steps.most == 0.0;
        self.steps.least = if is_first {
            size
        } else {
            size.min(self.steps.least)
        };
        self.steps.most = size.max(self.steps.most);
        None
    }

    /// Whether (H + e)∇g makes a part of ∇K = g∇H + (H + e)∇g that shows in the state. The term (H + e)∇g is 0 on the
    /// motion.
    ///
    /// The gradient ∇g is taken by central differences. An error of the balance below [`NEGLIGIBLE`] is not looked at.
    fn is_lost(&mut self, state: &[f64], balance: f64) -> bool {
        let energy = state[self.pace.clock.energy].abs();
        if balance.abs() <= NEGLIGIBLE * energy {
            return false;
        }
        if self.gradient.is_none() {
            let gradient = self.pace.system.gradient_values().ok();
            self.gradient = gradient.map(|map| map.evaluator(&self.parameters, 1.0, 1.0));
        }
        let Some(gradient) = &mut self.gradient else {
            return false;
        };
        let mut whole = vec![0.0; state.len()];
        if gradient.values(state, &mut whole).is_err() {
            return false;
        }
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let own = self.pace.names.len();
        let size = largest(&state[..own]);
        let mut near = state.to_vec();
        let mut slopes = vec![0.0; own];
        for (at, slope) in slopes.iter_mut().enumerate() {
            let width = libm::cbrt(f64::EPSILON) * size;
            let mut value = |x: f64| {
                near[at] = x;
                self.watched.at(&near)[0]
            };
            let (above, below) = (value(state[at] + width), value(state[at] - width));
            value(state[at]);
            *slope = (above - below) / (2.0 * width);
        }
        let part = balance.abs() * largest(&slopes);
        let step = self.step.abs();
        part > MOST_FALSE * largest(&whole[..own]) && part * step > MOST_MOVED * size
    }

    /// Whether ever more steps would lead to no end: the time advances with the logarithm of their number, or less.
    fn is_in_vain(&mut self, state: &[f64], made: u64) -> bool {
        let time = self.pace.time_at(state);
        let Some(until) = self.until else {
            return false;
        };
        if made < LEAST_DOUBLED || !made.is_power_of_two() {
            return false;
        }
        let advance = (time - self.steps.doubled).abs();
        let is_slower = made > LEAST_DOUBLED && advance <= self.steps.advance;
        self.steps.slower = if is_slower { self.steps.slower + 1 } else { 0 };
        self.steps.doubled = time;
        self.steps.advance = advance;
        let left = MOST_DOUBLINGS - f64::from(made.ilog2());
        self.steps.slower >= SLOWER && (until - time).abs() > left * advance
    }

    /// Whether the time has hardly advanced since the last look.
    fn stalls(&mut self, state: &[f64], made: u64) -> bool {
        if !made.is_multiple_of(LOOKED_OVER) {
            return false;
        }
        let time = self.pace.time_at(state);
        let seen = std::mem::replace(&mut self.steps.seen, time);
        let left = self.until.map_or(0.0, |until| (until - time).abs());
        (time - seen).abs() <= f64::max(STALLED * left, f64::EPSILON * time.abs())
    }

    /// The state at `time`, between the state before the last step and the one after it.
    pub fn state_at(
        &self,
        last: &mut LastStep<'_>,
        end: &StepEnd<'_>,
        time: f64,
    ) -> Result<Vec<f64>, StepError> {
        let t = self.pace.clock.time;
        let (state, low) = (&last.start.state, &last.start.compensation);
        let wanted = (time - state[t]) - low[t];
        let whole = last.advance(end, t);
        let rounding = f64::EPSILON * time.abs().max(whole.abs());
        let forward = 1.0_f64.copysign(whole);
        let values = [-wanted * forward, (whole - wanted) * forward];
        let bracket = last.enclose(
            last.ends(&end.state, values),
            &|missed| missed > 0.0,
            Some(0.5 * rounding),
            &mut |increment, _| (increment[t] - wanted) * forward,
        )?;
        let missed = bracket.nearest.value.abs();
        if missed <= MISSED * rounding {
            return Ok(bracket.nearest.state);
        }
        Err(StepError::NoConvergence {
            evaluations: bracket.tried,
            correction: missed / whole.abs(),
        })
    }
}
