//! Samples of a run, and gradients of functions of them.

use leafwise::core::gradient::{Gradient, Plan, Trajectory};
use leafwise::run::with_room;

use crate::call_error::CallError;
use crate::code::LeafwiseCode;
use crate::scene::Scene;

/// The plan of so many samples, the first of them the initial state.
fn plan(rows: usize, every: u64) -> Result<Plan, CallError> {
    let steps = (rows as u64)
        .checked_sub(1)
        .and_then(|rows| rows.checked_mul(every));
    match steps {
        Some(steps) if every > 0 => Ok(Plan { steps, every }),
        _ => Err(CallError::usage(format!(
            "{rows} samples every {every} steps: both numbers must be at least 1"
        ))),
    }
}

/// Refuses samples, those that are stepped and those that are handed out, that find no memory.
fn has_room(scene: &Scene, rows: usize) -> Result<(), CallError> {
    let width = 2 * scene.run.plan.layout.dimension();
    let room = with_room(rows as u64, width).map(drop);
    room.map_err(|no_room| CallError {
        code: LeafwiseCode::LEAFWISE_NO_MEMORY,
        message: no_room.to_string(),
    })
}

/// Calls with the trajectories of a scene.
fn along<T>(
    scene: &Scene,
    call: impl FnOnce(Trajectory<'_>) -> Result<T, CallError>,
) -> Result<T, CallError> {
    let run = &scene.run;
    run.has_equal_steps().map_err(|uneven| CallError {
        code: LeafwiseCode::LEAFWISE_UNSUPPORTED,
        message: uneven.to_string(),
    })?;
    call(Trajectory {
        map: run.method.map(),
        parameters: &run.system.parameter_values(),
        epsilon: run.plan.epsilon,
        h: run.plan.h,
        goes_on: &|| true,
    })
}

/// The samples of a scene, the scene's own coordinates row by row.
pub(crate) fn samples(scene: &Scene, rows: usize, every: u64) -> Result<Vec<f64>, CallError> {
    let plan = plan(rows, every)?;
    has_room(scene, rows)?;
    along(scene, |trajectory| {
        let reached = trajectory.run(&scene.run.plan.initial, plan)?;
        Ok(scene.run.own_rows(&reached.samples))
    })
}

/// The gradient of a function of the samples with these derivatives by them.
pub(crate) fn pull(
    scene: &Scene,
    every: u64,
    cotangents: &[f64],
    by_parameters: bool,
) -> Result<Gradient, CallError> {
    let rows = cotangents.len() / scene.run.plan.layout.coordinates();
    let plan = plan(rows, every)?;
    has_room(scene, rows)?;
    let cotangents = scene.run.whole_rows(cotangents);
    along(scene, |trajectory| {
        let initial = &scene.run.plan.initial;
        let reached = trajectory.run(initial, plan)?;
        Ok(trajectory.pull(initial, &reached, &cotangents, plan, (by_parameters, None))?)
    })
}
