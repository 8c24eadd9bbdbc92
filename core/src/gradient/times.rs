//! States at times between the steps of a trajectory, with their tangents.

use super::error::GradientError;
use super::trajectory::{Plan, Trajectory};

/// Roundings of a time that a step's end may be missed by: the length of a step is rounded too.
const MISSED: f64 = 64.0;

/// States at `times`, d numbers each, and their tangents, as of [`push`](Trajectory::push). The times go the way of
/// the steps. A state is that of the method's own steps up to the last one before its time, and of one shorter step
/// from there. Without tangents none are formed.
///
/// # Errors
/// [`GradientError`], with the number of the step in which a state could not be reached.
pub fn push(
    along: &Trajectory<'_>,
    (mut state, mut tangents): (Vec<f64>, Vec<f64>),
    by_parameters: &[f64],
    times: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), GradientError> {
    let step = along.epsilon * along.h;
    let mut states = Vec::with_capacity(times.len() * state.len());
    let mut moved = Vec::with_capacity(times.len() * tangents.len());
    let mut made = 0;
    for time in times {
        let parts = (time / step).max(made as f64);
        let nearest = parts.round();
        let is_met = (parts - nearest).abs() <= MISSED * f64::EPSILON * nearest;
        let before = if is_met { nearest } else { parts.floor() };
        let more = before as u64 - made;
        if more > 0 {
            let from = (&state[..], &tangents[..]);
            (state, tangents) = advanced(along, from, by_parameters, more, made)?;
            made += more;
        }
        if is_met {
            states.extend_from_slice(&state);
            moved.extend_from_slice(&tangents);
            continue;
        }
        let shorter = Trajectory {
            h: along.h * (parts - before),
            ..*along
        };
        let from = (&state[..], &tangents[..]);
        let (end, tangent) = advanced(&shorter, from, by_parameters, 1, made)?;
        states.extend(end);
        moved.extend(tangent);
    }
    Ok((states, moved))
}

/// The state after so many steps, and its tangents.
fn advanced(
    along: &Trajectory<'_>,
    (state, tangents): (&[f64], &[f64]),
    by_parameters: &[f64],
    steps: u64,
    made: u64,
) -> Result<(Vec<f64>, Vec<f64>), GradientError> {
    let plan = Plan {
        steps,
        every: steps,
    };
    let counted = |error| match error {
        GradientError::Step { step, error } => GradientError::Step {
            step: step + made,
            error,
        },
        other => other,
    };
    if tangents.is_empty() {
        let reached = along.run(state, plan).map_err(counted)?;
        return Ok((reached.end(state.len()).0.to_vec(), Vec::new()));
    }
    let directions = (tangents, by_parameters);
    let pushed = along.push(state, directions, plan).map_err(counted)?;
    let last = |rows: &[f64], width: usize| rows[rows.len() - width..].to_vec();
    Ok((
        last(&pushed.samples, state.len()),
        last(&pushed.tangents, tangents.len()),
    ))
}
