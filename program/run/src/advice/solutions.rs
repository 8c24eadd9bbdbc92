//! A step whose equation has several solutions inside the chart.

use super::probe::{Probe, distance, size};
use super::step::half_the_step;
use super::{Advice, AdviceKind, number};

/// Starts of Newton's method at each state.
const STARTS: usize = 16;

/// Most operations that the search may cost: about a second.
const MOST_OPERATIONS: u64 = 1_000_000_000;

/// Solutions further away, in motions of the step, are out of reach of any start: a solver begins within one.
const FAR: f64 = 10.0;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let (mut several, mut nearest) = (0, f64::INFINITY);
    for place in &probe.places {
        let others = probe.equation.others(&place.x, STARTS, MOST_OPERATIONS);
        let Ok(others) = others else {
            continue;
        };
        let others = others.iter();
        let apart = others.map(|other| distance(&other.y, &place.solution.y));
        let closest = apart.fold(f64::INFINITY, f64::min);
        if closest <= FAR * size(&place.solution.increment) {
            several += 1;
            nearest = nearest.min(closest / size(&place.x));
        }
    }
    (several > 0).then(|| Advice {
        kind: AdviceKind::SeveralSolutions,
        message: format!(
            "the equation of a step has several solutions inside {}'s chart, at {several} of {} \
             states; the nearest other one is {} of the state's size away. Which one a step takes \
             depends on where its solver starts",
            probe.realization.name,
            probe.places.len(),
            number(nearest)
        ),
        change: half_the_step(probe.run),
    })
}
