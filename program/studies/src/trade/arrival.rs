//! States at a given time of runs whose steps are of a fictitious time τ.

use leafwise_core::{StepError, Walk};
use leafwise_scene::ComposedRun;

use super::error::TradeError;

/// Steps of a scene by its own method, at most, to find out how far they go in τ.
const MOST_STEPS: u64 = 1 << 24;

/// Steps that are tried for one that ends at a time.
const MOST_TRIED: usize = 30;

/// Roundings of a time that it may be missed by.
const MISSED: f64 = 4.0;

/// From the scene's initial state, with its parameters.
pub(super) fn walk(run: &ComposedRun, epsilon: f64, h: f64) -> Walk {
    let values = run.system.parameter_values();
    Walk::new(run.method.map(), &values, epsilon, h, &run.plan.initial)
}

/// The state at `time` near a state of a paced run: the end of one more step of its method, forwards or backwards, and the
/// length of that step. Its length follows from dt/dτ = g by Newton's method.
pub(super) fn arrive(
    run: &ComposedRun,
    epsilon: f64,
    state: &[f64],
    time: f64,
) -> Result<(f64, Vec<f64>), StepError> {
    let (Some(pace), Some(place)) = (run.pace(), run.time_place()) else {
        return Ok((0.0, state.to_vec()));
    };
    let parameters = run.system.parameter_values();
    let (mut h, mut end) = (0.0, state.to_vec());
    for _ in 0..MOST_TRIED {
        let missed = time - end[place];
        if missed.abs() <= MISSED * f64::EPSILON * time.abs() {
            return Ok((h, end));
        }
        h += missed / (epsilon * pace.formula.evaluate(&end, &parameters));
        let mut step = Walk::new(run.method.map(), &parameters, epsilon, h, state);
        step.step()?;
        end.copy_from_slice(step.state());
    }
    let correction = (time - end[place]).abs();
    Err(StepError::NoConvergence {
        evaluations: MOST_TRIED,
        correction,
    })
}

/// How far a paced scene goes by its own method: t, which stands at `place`, at the end, and τ. It ends at `time`, where that is
/// given.
///
/// # Errors
/// [`TradeError::NoReference`] where a step fails, [`TradeError::TooLong`] where the time does not come in 2²⁴ steps.
pub(super) fn way(
    run: &ComposedRun,
    place: usize,
    time: Option<f64>,
) -> Result<(f64, f64), TradeError> {
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let failed = |error: StepError| TradeError::NoReference {
        reasons: vec![format!("the scene's own method: {error}")],
    };
    let mut walk = walk(run, epsilon, h);
    let is_there = |walk: &Walk| match time {
        Some(time) => (walk.state()[place] - time) * (epsilon * h) >= 0.0,
        None => walk.steps() >= run.plan.steps,
    };
    if !is_there(&walk) {
        let arrived = walk.watch_until(MOST_STEPS, |walk| {
            (walk.steps() < MOST_STEPS && is_there(walk)).then_some(())
        });
        if arrived.map_err(failed)?.is_none() {
            return Err(TradeError::TooLong {
                time: time.unwrap_or(walk.state()[place]),
                steps: walk.steps() as f64,
            });
        }
    }
    let made = walk.steps() as f64 * h;
    let end = time.unwrap_or(walk.state()[place]);
    let (more, _) = arrive(run, epsilon, walk.state(), end).map_err(failed)?;
    Ok((end, epsilon * (made + more)))
}
