//! Stage equations by fixed-point iteration, the stages side by side in the lanes of vectors.
//!
//! - [`solution`]: one solve, its start and its outcome.
//! - [`sums`]: z + τ Σ_j a_ij f_j over lanes i.
//! - [`lanes`]: stages and slopes of several trajectories, and one correction.
//! - [`iteration`]: corrections until they are negligible, and their judgement.
//! - [`path`]: the starts of a solve: the last step's polynomial, z, parts of the step.

mod iteration;
mod lanes;
mod path;
mod solution;
mod sums;
#[cfg(test)]
mod tests;

use super::smooth_map::MapAt;
use super::tableau::Tableau;
use lanes::Lanes;
use path::SMOOTH;
pub(crate) use solution::{FixedPoint, StageLanes, Start};

/// Solves of `count` trajectories with a Gauss method; none where F has no kernel. F reads Z, then what it reads beside. Where a
/// solution is not found at once it `follows` the step from z by parts, or leaves it to another solver.
pub(crate) fn stage_lanes(
    field: MapAt<'_>,
    tableau: &Tableau,
    time_step: f64,
    count: usize,
    follows: bool,
) -> Option<Box<dyn StageLanes>> {
    if tableau.stages() < SMOOTH && !follows {
        return None;
    }
    let shape = (field, tableau, time_step, count, follows);
    Some(match tableau.stages() {
        1 => Box::new(Lanes::<1>::new(shape)?),
        2 => Box::new(Lanes::<2>::new(shape)?),
        3..=4 => Box::new(Lanes::<4>::new(shape)?),
        5..=8 => Box::new(Lanes::<8>::new(shape)?),
        9..=16 => Box::new(Lanes::<16>::new(shape)?),
        _ => return None,
    })
}
