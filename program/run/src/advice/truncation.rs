//! A truncation order above what a step can feel.

use leafwise_core::{Ends, RealizationData, realization_evaluator};

use super::probe::{Probe, distance, size};
use super::{Advice, AdviceKind};

/// Half a unit in the last place of 1.
pub(super) const ROUND_OFF: f64 = f64::EPSILON / 2.0;

/// Smallest part of its own size that the compensated state feels. A remainder below this part of an ulp was not
/// visible in Casimirs after 10⁶ steps.
pub(super) const FELT: f64 = ROUND_OFF / 32.0;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let n = probe.truncation_order()?;
    let whole = ends(probe, probe.method.realization())?;
    let mut enough = n;
    while enough > 1 {
        let Ok(shorter) = probe.truncated(enough - 1) else {
            break;
        };
        let Some(shorter) = ends(probe, shorter.as_ref()) else {
            break;
        };
        if !is_same(probe, &whole, &shorter) {
            break;
        }
        enough -= 1;
    }
    (enough < n).then(|| {
        let name = probe.realization.name;
        Advice {
            kind: AdviceKind::TruncationOrder,
            message: format!(
                "{name} of order {n}: at the run's states its terms after order {enough} are below \
                 the round-off of a step"
            ),
            change: format!("realization = {{ name = \"{name}\", order = {enough} }}"),
        }
    })
}

/// Base, β̂ − base and α̂ − β̂ at the run's points.
fn ends(probe: &Probe<'_>, realization: &dyn RealizationData) -> Option<Vec<Vec<f64>>> {
    let mut evaluator =
        realization_evaluator(realization, &probe.parameters, probe.run.plan.epsilon).ok()?;
    let ends = probe.places.iter().map(|place| {
        let mut ends = vec![0.0; 3 * place.x.len()];
        evaluator.values(&place.solution.point, &mut ends).ok()?;
        Some(ends)
    });
    ends.collect()
}

/// Whether two truncations give the same steps: what they differ by is the round-off of forming the
/// increment, or not felt by the state.
fn is_same(probe: &Probe<'_>, whole: &[Vec<f64>], shorter: &[Vec<f64>]) -> bool {
    probe
        .places
        .iter()
        .zip(whole.iter().zip(shorter))
        .all(|(place, (whole, shorter))| {
            let (whole, shorter) = (Ends::of(whole), Ends::of(shorter));
            let allowed = ROUND_OFF * size(whole.increment) + FELT * size(&place.x);
            distance(whole.increment, shorter.increment) <= allowed
                && distance(whole.offset, shorter.offset) <= allowed
        })
}
