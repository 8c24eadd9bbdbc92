//! Newton's method on equations, as many as unknowns or more: the least correction that makes the sum of their squares least, halved
//! until that sum falls.

use super::linear::{Columns, SingularValues};

/// Newton steps, at most.
const STEPS: usize = 40;

/// Halvings of one.
const HALVINGS: usize = 10;

/// Equations at a point, with what was computed there.
pub(super) struct At<A> {
    pub found: A,
    /// The right-hand side of the correction: the equations' values with the other sign.
    pub right: Vec<f64>,
}

/// The end of a search.
pub(super) struct Corrected<A> {
    pub unknowns: Vec<f64>,
    pub at: At<A>,
    pub corrections: usize,
}

/// Corrects unknowns until no correction makes the equations better, or half as good below `near`. Below `near` whole corrections alone are tried: near round-off
/// a shorter one is no better. `columns` are derivatives of the equations, and `watch` ends the search.
pub(super) fn corrected<A, E>(
    mut unknowns: Vec<f64>,
    (part, near): (f64, f64),
    mut at: impl FnMut(&[f64]) -> Result<At<A>, E>,
    mut columns: impl FnMut(&[f64], &At<A>) -> Result<Columns, E>,
    mut watch: impl FnMut(&[f64], usize) -> Result<(), E>,
) -> Result<Corrected<A>, E> {
    let mut here = at(&unknowns)?;
    let mut corrections = 0;
    while corrections < STEPS && length(&here.right) > 0.0 {
        let derivatives = columns(&unknowns, &here)?;
        let change = SingularValues::of(&derivatives).solve(&here.right, part);
        let before = length(&here.right);
        let halvings = if before > near { HALVINGS } else { 1 };
        let better = (0..halvings).find_map(|halving| {
            let part = libm::exp2(-(halving as f64));
            let pairs = unknowns.iter().zip(&change);
            let moved: Vec<f64> = pairs.map(|(u, du)| u + part * du).collect();
            let next = at(&moved).ok()?;
            (length(&next.right) < before).then_some((moved, next))
        });
        let Some((moved, next)) = better else { break };
        corrections += 1;
        (unknowns, here) = (moved, next);
        // At round-off corrections go to and fro.
        if before <= near && length(&here.right) > 0.5 * before {
            break;
        }
        watch(&unknowns, corrections)?;
    }
    Ok(Corrected {
        unknowns,
        at: here,
        corrections,
    })
}

pub(super) fn length(v: &[f64]) -> f64 {
    libm::sqrt(v.iter().map(|x| x * x).sum())
}
