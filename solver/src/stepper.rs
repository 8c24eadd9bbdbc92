//! Steppers, which take steps: one thread's, of one trajectory or of several side by side.

use leafwise_expression::kernel::apart;

use super::record::StepRecord;
use super::statistics::SolverStatistics;
use crate::compensation::two_sum;
use crate::error::StepError;

/// Setting of a [`Stepper`] that may change between steps.
#[derive(Clone, Copy, Debug)]
pub enum Setting<'a> {
    /// Step size h, with which earlier steps and their work are forgotten: later ones have the bits of those of a new
    /// stepper, and so has what is counted.
    StepSize(f64),
    /// Parameters, a structure of arrays over the lanes. Steps have the bits of those of a stepper made with them, up to
    /// where a solve starts.
    Parameters(&'a [f64]),
    /// Members of an ensemble that the lanes are: steps with noise draw their numbers. Without it lane w
    /// is member w.
    Members(&'a [u64]),
}

/// One thread's stepper of a step map M → M.
pub trait Stepper: Send {
    /// Φ(x + low) − (x + low) for each lane, where `low` carries what the compensated state holds
    /// beyond a double. Arrays are structures of arrays, coordinate j of lane w at `[j*lanes + w]`.
    /// A lane that fails keeps a zero increment; `outcome[w]` says why.
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    );
    /// Up to `steps` steps x_{k+1} = x_k + Δ_k of a stepper of one lane; x_k is `state` + `low`, and what rounding
    /// takes from a sum stays in `low`. Returns the steps made, and what ended them: the state is then that before
    /// the step that failed. `increment` is room for Δ_k. Where there is a `check`, it looks at every step before
    /// that is taken. Where there is a `record`, it takes every state that a step has led to.
    fn advance(
        &mut self,
        steps: u64,
        state: &mut [f64],
        low: &mut [f64],
        increment: &mut [f64],
        check: Option<&mut dyn StepCheck>,
        record: Option<&mut StepRecord<'_>>,
    ) -> (u64, Result<(), StepError>) {
        one_by_one(self, steps, [state, low, increment], check, record)
    }
    /// The solution y of β̂(L(y)) = x of a lane's last step, `None` for a map without a bisection.
    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        let _ = lane;
        None
    }
    /// DΦ of a lane's last step, row-major d × d, exact through the solve; `None` where it is not
    /// offered.
    fn tangent(&mut self, lane: usize) -> Option<Vec<f64>> {
        let _ = lane;
        None
    }
    /// Forgets earlier steps: the next solve starts cold.
    fn restart(&mut self);
    /// Takes another setting for the steps that follow. Returns whether that is offered; where it is not, another stepper is
    /// to be made.
    fn set(&mut self, setting: Setting<'_>) -> bool {
        let _ = setting;
        false
    }
    /// Work done so far, which an observer of every step asks for.
    fn statistics(&self) -> SolverStatistics;
    /// Everything that later steps depend on beyond the state, for a checkpoint.
    fn memory(&self) -> Vec<f64>;
    /// Restores [`Stepper::memory`].
    ///
    /// # Errors
    /// Returns the expected length when `memory` has another.
    fn restore(&mut self, memory: &[f64]) -> Result<(), usize>;
}

/// [`Stepper::advance`] by [`Stepper::increment`].
pub fn one_by_one<S: Stepper + ?Sized>(
    stepper: &mut S,
    steps: u64,
    [state, low, increment]: [&mut [f64]; 3],
    mut check: Option<&mut dyn StepCheck>,
    mut record: Option<&mut StepRecord<'_>>,
) -> (u64, Result<(), StepError>) {
    for made in 0..steps {
        let mut outcome = [Ok(())];
        stepper.increment(state, low, increment, &mut outcome);
        if let Some(check) = &mut check {
            check.check(state, increment, &mut outcome);
        }
        let [outcome] = outcome;
        if let Err(error) = outcome.and_then(|()| add(state, low, increment)) {
            return (made, Err(error));
        }
        if let Some(record) = &mut record {
            record.take(state, stepper.statistics().evaluations);
        }
    }
    (steps, Ok(()))
}

/// The most coordinates that are kept [`apart`]: more take longer to add than to load.
const FEW: usize = 16;

/// x ← x + Δ, what rounding takes from the sum in `low`; an x + Δ that overflows is refused, and x is as it was.
#[inline(always)]
pub fn add(x: &mut [f64], low: &mut [f64], increment: &[f64]) -> Result<(), StepError> {
    if x.len() <= FEW {
        return add_between(x, low, increment, apart::<1>);
    }
    if !are_finite(x, increment) {
        return Err(StepError::OF_STATE);
    }
    add_finite(x, low, increment);
    Ok(())
}

/// Whether every x + Δ is finite.
#[inline]
pub fn are_finite(x: &[f64], increment: &[f64]) -> bool {
    are_finite_between(x, increment, || ())
}

/// The same with something between two coordinates.
#[inline(always)]
fn are_finite_between(x: &[f64], increment: &[f64], between: impl Fn()) -> bool {
    // 0·v is 0 where v is finite, and no number elsewhere. Several sums do not wait for each other.
    let mut zeros = [0.0; 8];
    let ((rows, rest), (changes, others)) = (x.as_chunks::<8>(), increment.as_chunks::<8>());
    for (x, change) in rows.iter().zip(changes) {
        for at in 0..8 {
            zeros[at] += 0.0 * (x[at] + change[at]);
            between();
        }
    }
    for (x, change) in rest.iter().zip(others) {
        zeros[0] += 0.0 * (x + change);
        between();
    }
    !zeros.iter().sum::<f64>().is_nan()
}

/// [`add`] of x + Δ that [are finite](are_finite).
#[inline]
pub fn add_finite(x: &mut [f64], low: &mut [f64], increment: &[f64]) {
    let ((rows, rest), (lows, own), (changes, others)) = (
        x.as_chunks_mut::<8>(),
        low.as_chunks_mut::<8>(),
        increment.as_chunks::<8>(),
    );
    for ((x, low), change) in rows.iter_mut().zip(lows).zip(changes) {
        for at in 0..8 {
            (x[at], low[at]) = two_sum(x[at], change[at] + low[at]);
        }
    }
    for ((x, low), change) in rest.iter_mut().zip(own).zip(others) {
        (*x, *low) = two_sum(*x, change + *low);
    }
}

/// The same as [`add`] with something between two coordinates.
#[inline(always)]
fn add_between(
    x: &mut [f64],
    low: &mut [f64],
    increment: &[f64],
    between: impl Fn(),
) -> Result<(), StepError> {
    if !are_finite_between(x, increment, &between) {
        return Err(StepError::OF_STATE);
    }
    for ((x, low), change) in x.iter_mut().zip(low).zip(increment) {
        (*x, *low) = two_sum(*x, change + *low);
        between();
    }
    Ok(())
}

/// Restores steppers from what the memory of each held, one behind the other; the number of entries that they have where it
/// is another.
pub fn restore_each<'own, S: Stepper + ?Sized + 'own>(
    steppers: impl Iterator<Item = &'own mut S>,
    memory: &[f64],
) -> Result<(), usize> {
    let steppers: Vec<(&mut S, usize)> = steppers
        .map(|stepper| {
            let length = stepper.memory().len();
            (stepper, length)
        })
        .collect();
    let expected = steppers.iter().map(|(_, length)| length).sum();
    if memory.len() != expected {
        return Err(expected);
    }
    let mut rest = memory;
    for (stepper, length) in steppers {
        let (own, others) = rest.split_at(length);
        stepper.restore(own)?;
        rest = others;
    }
    Ok(())
}

/// Condition that a step from x to x + Δ must fulfil beyond its own equations.
pub trait StepCheck: Send {
    /// Replaces the outcome of each lane whose finished step does not fulfil it. Arrays are those of
    /// [`Stepper::increment`].
    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]);
    /// Whether its answer may depend on this coordinate.
    fn reads(&self, coordinate: usize) -> bool {
        let _ = coordinate;
        true
    }
    /// Takes other parameters, a structure of arrays over the lanes.
    fn set_parameters(&mut self, parameters: &[f64]) {
        let _ = parameters;
    }
}
