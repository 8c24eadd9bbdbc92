//! One trajectory: the polynomial that it is followed on, and how far.

use leafwise_core::solver::judge::larger;
use leafwise_core::system::FieldRounding;
use leafwise_core::{StepError, two_sum};

use super::polynomial::{length, polynomial, short};
use crate::adaptive::STILL;
use crate::allowed::Allowed;
use crate::floors::Floors;

/// A substep is at most so many times the last: coefficients that vanish by chance show no radius.
const GROW: f64 = 8.0;

/// A substep that a look refuses is multiplied by a number between these.
const SHRINK: [f64; 2] = [0.125, 0.9];

/// A residual of so many times the bound on the field's rounding errors is round-off: that of the field here, and of the
/// jet's at the base.
const WITHIN: f64 = 4.0;

/// The polynomial about `base`, along which a trajectory is followed to `reached`. Times are in the series' unit.
#[derive(Clone)]
pub(super) struct Path {
    pub base: Vec<f64>,
    /// Low parts of the base's coordinates, beyond their doubles.
    pub low: Vec<f64>,
    /// x_k[i] at (k − 1)d + i.
    pub jet: Vec<f64>,
    /// Whether the jet is that of the base.
    pub has_jet: bool,
    /// The length of the substep from the base; 0 before it is chosen.
    pub length: f64,
    /// That of the substep before, 0 before there is any.
    pub before: f64,
    /// The time since the base, as a sum of two doubles.
    pub reached: [f64; 2],
    /// The time since the base at which the polynomial was last looked at and passed.
    pub passed: f64,
    /// Errors of coordinates below which nothing is looked at, from the first refused look on.
    pub floors: Floors,
    pub needs_floors: bool,
    /// The state that was handed out there; none before the first step.
    pub state: Vec<f64>,
    pub begun: bool,
    /// Whether this substep crosses a jump of the field.
    is_crossing: bool,
    /// Whether the step ends here.
    pub is_done: bool,
    /// The time that is looked at, and change and slope of the polynomial there.
    at: f64,
    pub change: Vec<f64>,
    slope: Vec<f64>,
}

impl Path {
    pub fn new(dimension: usize, order: usize) -> Self {
        let zeros = vec![0.0; dimension];
        Self {
            base: zeros.clone(),
            low: zeros.clone(),
            jet: vec![0.0; order * dimension],
            has_jet: false,
            length: 0.0,
            before: 0.0,
            reached: [0.0; 2],
            passed: 0.0,
            floors: Floors::new(dimension),
            needs_floors: false,
            state: zeros.clone(),
            begun: false,
            is_crossing: false,
            is_done: false,
            at: 0.0,
            change: zeros.clone(),
            slope: zeros,
        }
    }

    /// Goes on from x by a time, on the same polynomial where x is the state it was left at.
    pub fn begin(&mut self, x: &[f64], low: &[f64], time_step: f64) {
        if !self.begun || self.state != x {
            self.base.copy_from_slice(x);
            self.low.copy_from_slice(low);
            self.reached = [0.0; 2];
            self.before = 0.0;
            self.begun = true;
            self.forget();
        }
        let [time, low] = self.reached;
        let (time, low) = two_sum(time, time_step + low);
        self.reached = [time, low];
        self.is_done = false;
    }

    /// The base has no polynomial yet.
    fn forget(&mut self) {
        self.has_jet = false;
        self.is_crossing = false;
        self.length = 0.0;
        self.passed = 0.0;
        self.floors.clear();
        self.needs_floors = false;
    }

    /// Forms the floors for a time.
    pub fn form_floors(&mut self, field: (&FieldRounding, &[f64], f64), time: f64) {
        let slope = &self.jet[..self.base.len()];
        self.floors.form(field, &self.base, slope, time);
    }

    /// The time since the base that was looked at last.
    pub fn looked_at(&self) -> f64 {
        self.at
    }

    /// Moves the base to the end of its substep, which was looked at last.
    fn advance(&mut self) {
        let length = self.length;
        for ((base, low), change) in self.base.iter_mut().zip(&mut self.low).zip(&self.change) {
            (*base, *low) = two_sum(*base, *change + *low);
        }
        // The length has half of a double's digits: the difference is exact.
        self.reached[0] -= length;
        self.before = length.abs();
        let time = match self.needs_floors {
            true => self.floors.time,
            false => 0.0,
        };
        self.forget();
        self.floors.time = time;
    }

    /// The length of the substep from the base, in the direction of `direction`.
    ///
    /// # Errors
    /// [`StepError::NonFinite`] where a coefficient is not finite.
    pub fn choose(
        &mut self,
        direction: f64,
        safety: f64,
        allowed: &Allowed,
    ) -> Result<(), StepError> {
        let d = self.base.len();
        let order = self.jet.len() / d;
        let row = |k: usize| &self.jet[(k - 1) * d..][..d];
        let (first, second, earlier, last) = (row(1), row(2), row(order - 1), row(order));
        // Before the first substep, its length by the field alone.
        let before = match self.before > 0.0 {
            true => self.before,
            false if allowed.has_floors() => length(steepest(first, last), order - 1),
            false => length(size(last) / size(first), order - 1),
        };
        // The largest x_k[i] over component i, or over its change where that is larger. What is 0 up to the second order is
        // measured by its own terms, or counts as round-off of the others, or of their change where all are 0.
        let whole = match size(&self.base) {
            0.0 => before * (size(first) + before * size(second)),
            base => base,
        };
        let (mut of_earlier, mut of_last) = (0.0_f64, 0.0_f64);
        for i in 0..d {
            let change = before * (first[i].abs() + before * second[i].abs());
            let own = self.base[i].abs().max(change);
            let least = if allowed.keeps_sign(i) {
                0.0
            } else if allowed.has_floors() {
                let begins = if own == 0.0 {
                    self.begins(i, before)
                } else {
                    0.0
                };
                begins.max(self.floors.rough(i))
            } else {
                f64::EPSILON * whole
            };
            let floor = least + f64::MIN_POSITIVE;
            let scale = 1.0 / own.max(floor);
            of_earlier = larger(of_earlier, earlier[i].abs() * scale);
            of_last = larger(of_last, last[i].abs() * scale);
        }
        if !(of_earlier + of_last).is_finite() {
            return Err(StepError::NonFinite {
                what: "the Taylor series of the motion",
            });
        }
        let most = match self.before > 0.0 {
            true => GROW * self.before,
            false if of_last + of_earlier == 0.0 => direction.abs(),
            false => f64::INFINITY,
        };
        let chosen = length(of_earlier, order - 1).min(length(of_last, order));
        self.length = short((safety * chosen).min(most)).copysign(direction);
        Ok(())
    }

    /// max over k of |x_k[i]| tᵏ.
    fn begins(&self, i: usize, time: f64) -> f64 {
        let rows = self.jet.chunks_exact(self.base.len());
        let terms = rows.scan(1.0, |power, row| {
            *power *= time;
            Some(*power * row[i].abs())
        });
        terms.fold(0.0, f64::max)
    }

    /// Makes the substep one that crosses a jump of the field, unless it was one in vain.
    pub fn cross(&mut self, length: f64) {
        if self.has_jet && !self.is_crossing && length.abs() <= self.reached[0].abs() {
            self.is_crossing = true;
            self.length = length;
        }
    }

    /// Whether the place looked at is the end of a substep that crosses a jump, and nothing moves by much on the way.
    pub fn crosses(&self) -> bool {
        self.is_crossing && size(&self.change) <= STILL * size(&self.base)
    }

    /// Whether the step goes on behind the substep.
    pub fn goes_on(&self) -> bool {
        !self.is_done && self.reached[0].abs() > self.length.abs()
    }

    /// Moves to where the polynomial is looked at next, the end of the step or that of the substep, and writes its
    /// state there.
    pub fn look(&mut self, state: &mut [f64]) {
        let [time, low] = self.reached;
        self.at = if self.goes_on() {
            self.length
        } else {
            time + low
        };
        polynomial(&self.jet, self.at, &mut self.change, &mut self.slope);
        for (i, state) in state.iter_mut().enumerate() {
            *state = self.base[i] + (self.low[i] + self.change[i]);
        }
    }

    /// Largest |P′_i − f_i| t/(p + 1) over the error that x_i may have. The first term that P leaves out is below
    /// that. At the place looked at, `field` is f times the unit of time.
    ///
    /// The size of x_i is its own or t |P′_i| where that is larger. A coordinate that keeps its sign is measured by
    /// itself alone, and it has to keep it.
    pub fn excess(&self, field: &[f64], allowed: &Allowed) -> f64 {
        let largest = self.largest();
        (0..field.len()).fold(0.0, |most, i| {
            larger(most, self.excess_of(i, field, largest, allowed))
        })
    }

    /// max over i of |P_i| and t |P′_i|.
    fn largest(&self) -> f64 {
        let time = self.at.abs();
        let pairs = self.base.iter().zip(&self.change).zip(&self.slope);
        pairs.fold(0.0, |most, ((base, change), slope)| {
            most.max((base + change).abs()).max(time * slope.abs())
        })
    }

    /// Whether a coordinate has more of the residual than is allowed for its own size.
    pub fn exceeds_itself(&self, field: &[f64], allowed: &Allowed) -> bool {
        let all = 0..field.len();
        let mut pairs = all.filter_map(|i| self.residual(i, field, allowed));
        pairs.any(|(error, size)| error > allowed.of_itself(size))
    }

    #[inline(always)]
    fn excess_of(&self, i: usize, field: &[f64], largest: f64, allowed: &Allowed) -> f64 {
        match self.residual(i, field, allowed) {
            Some((error, size)) => error / allowed.error(i, size, largest, &self.floors),
            None => f64::INFINITY,
        }
    }

    /// The residual of x_i and what it is measured by; none where a sign is lost.
    #[inline(always)]
    fn residual(&self, i: usize, field: &[f64], allowed: &Allowed) -> Option<(f64, f64)> {
        let (base, slope, time) = (self.base[i], self.slope[i], self.at.abs());
        let value = base + (self.low[i] + self.change[i]);
        let is_kept = allowed.keeps_sign(i);
        let size = match is_kept {
            true => value.abs(),
            false => value.abs().max(time * slope.abs()),
        };
        let terms = (self.jet.len() / self.base.len() + 1) as f64;
        let error = (slope - field[i]).abs() * time / terms;
        let is_lost = (value > 0.0) != (base > 0.0) || value == 0.0;
        if is_kept && is_lost && base != 0.0 {
            return None;
        }
        Some((error, size))
    }

    /// How far rounding may have moved the coordinates of the place looked at: the base and the change.
    pub fn roundings(&self, errors: &mut [f64]) {
        for (i, error) in errors.iter_mut().enumerate() {
            *error = f64::EPSILON * (self.base[i].abs() + self.change[i].abs());
        }
    }

    /// Whether what is too much of the residual is round-off, for bounds on that of the field.
    pub fn is_round_off(&self, field: &[f64], bounds: &[f64], allowed: &Allowed) -> bool {
        let largest = self.largest();
        (0..field.len()).all(|i| {
            let excess = self.excess_of(i, field, largest, allowed);
            if excess <= 1.0 || excess.is_infinite() {
                return excess <= 1.0;
            }
            let own = f64::EPSILON * (self.jet[i].abs() + self.slope[i].abs());
            (self.slope[i] - field[i]).abs() <= WITHIN * (bounds[i] + own)
        })
    }

    /// Takes in a look that passed: the end of the step, or a new base.
    pub fn pass(&mut self) {
        self.passed = self.at;
        match self.goes_on() {
            true => self.advance(),
            false => self.is_done = true,
        }
    }

    /// Takes in a look that failed: the substep ends before.
    pub fn shorten(&mut self, excess: f64) {
        let order = self.jet.len() / self.base.len();
        let [least, most] = SHRINK;
        let factor = match excess.is_finite() {
            true => libm::pow(0.5 / excess, 1.0 / order as f64).clamp(least, most),
            false => 0.5,
        };
        let next = short(factor * self.at);
        // What passed before is not looked for again.
        let is_known = next.abs() < self.passed.abs() && self.passed.abs() < self.at.abs();
        self.length = if is_known { short(self.passed) } else { next };
    }
}

/// The largest last term of a coordinate over its first.
fn steepest(first: &[f64], last: &[f64]) -> f64 {
    let pairs = first.iter().zip(last);
    let moves = pairs.filter(|(first, _)| **first != 0.0);
    moves.fold(0.0, |most, (first, last)| {
        larger(most, (last / first).abs())
    })
}

/// max |v_i|.
fn size(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| v.abs().max(most))
}
