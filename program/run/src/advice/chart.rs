//! A step that nearly leaves the realization's chart.

use leafwise_core::RealizationMaps;

use super::probe::{Place, Probe};
use super::step::half_the_step;
use super::{Advice, AdviceKind, number};

/// The part of the chart's radius from which on it is nearly used up.
const NEARLY: f64 = 0.8;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let ratio = |place: &Place| place.solution.chart_ratio.unwrap_or(0.0);
    let farthest = probe
        .places
        .iter()
        .max_by(|a, b| ratio(a).total_cmp(&ratio(b)))?;
    // Of a series the ratio is that of the last term to the first: the radius to a power.
    let power = 1.0 / (last_term(probe, farthest).max(2) - 1) as f64;
    let used = libm::pow(ratio(farthest), power);
    (used >= NEARLY).then(|| Advice {
        kind: AdviceKind::Chart,
        message: format!(
            "a step goes {} of the way to the edge of {}'s chart, beyond which there is no step",
            number(used),
            probe.realization.name
        ),
        change: half_the_step(probe.run),
    })
}

/// The order of the last term of a series that does not vanish; 2 where there is no series.
fn last_term(probe: &Probe<'_>, place: &Place) -> usize {
    let Some(mut order) = probe.truncation_order() else {
        return 2;
    };
    let epsilon = probe.run.plan.epsilon;
    let ratio_of = |order: usize| {
        let shorter = probe.truncated(order).ok()?;
        let maps = RealizationMaps::new(shorter.as_ref(), probe.parameters.len()).ok()?;
        let mut ratio = maps.chart_ratio(&probe.parameters, epsilon)?;
        ratio.at(&place.solution.point)
    };
    while order > 2 && ratio_of(order - 1) == place.solution.chart_ratio {
        order -= 1;
    }
    order
}
