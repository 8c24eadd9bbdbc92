//! A step that the state's round-off decides: from the neighbouring double it leads elsewhere.

use super::step::{difference, increment};
use super::{Advice, AdviceKind, number};
use crate::compose::ComposedRun;

/// The part of a step's motion that one unit of round-off in the state may change: of sixteen digits that a
/// double has, three are left.
const DECIDED: f64 = 1e-3;

/// At the first of the run's states where a step from there and one from its neighbour differ by more.
pub(super) fn advice(run: &ComposedRun, states: &[Vec<f64>]) -> Option<Advice> {
    let message = states.iter().find_map(|x| {
        let neighbour: Vec<f64> = x.iter().map(|x| x + x * f64::EPSILON).collect();
        let (here, there) = (increment(run, x, 1), increment(run, &neighbour, 1));
        let part = difference(x, &here.ok()?, &there.ok()?);
        (part > DECIDED).then(|| {
            format!(
                "the state's round-off decides where a step leads: one unit of it changes a coordinate's motion \
                 by {} of it",
                number(part)
            )
        })
    })?;
    Some(Advice {
        kind: AdviceKind::RoundOff,
        message,
        change: "[system] in other units, or about another origin: sums and arguments of functions of at most 1e8"
            .to_owned(),
    })
}
