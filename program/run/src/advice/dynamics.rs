//! Terms of the generating function below the realization's own error.

use leafwise_core::diagnostics::StepEquation;
use leafwise_core::{Method, PartInfo, PartKind};

use super::probe::{Probe, distance};
use super::{Advice, AdviceKind, number};

/// Below this part of the realization's error a term is not worth its operations.
const WORTH: f64 = 0.1;

pub(super) fn advice(probe: &mut Probe<'_>) -> Option<Advice> {
    let n = probe.truncation_order()?;
    let m = probe.method.dynamics().properties().order;
    let is_of_order = |info: &PartInfo| info.name == probe.dynamics.name;
    let of_order = probe.registry.of_order(PartKind::Dynamics);
    if !of_order.is_ok_and(is_of_order) || m <= 2 || m <= n {
        return None;
    }
    let name = probe.dynamics.name;
    let places = &probe.places;
    let own: Vec<_> = places
        .iter()
        .map(|place| place.solution.increment.clone())
        .collect();
    // Two orders more: of a linear tensor every other one vanishes.
    let error = largest(&own, &steps(probe, n + 2, m)?);
    let (mut enough, mut lost) = (m, 0.0);
    while enough > 2 {
        let Some(shorter) = steps(probe, n, enough - 2) else {
            break;
        };
        let change = largest(&own, &shorter);
        if change > WORTH * error {
            break;
        }
        (enough, lost) = (enough - 2, change);
    }
    (enough < m).then(|| Advice {
        kind: AdviceKind::DynamicsOrder,
        message: format!(
            "{name} of order {m} over {} of order {n}: its terms after order {enough} \
             change a step by at most {}, and truncating the realization changes it by {}",
            probe.realization.name,
            number(lost),
            number(error)
        ),
        change: format!("dynamics = {{ name = \"{name}\", order = {enough} }}"),
    })
}

/// The steps from the run's states with realization and dynamics of these orders.
fn steps(probe: &Probe<'_>, n: usize, m: usize) -> Option<Vec<Vec<f64>>> {
    let (realization, dynamics) = (probe.truncated(n).ok()?, probe.of_order(m).ok()?);
    let method = Method::compose(probe.system(), realization, dynamics).ok()?;
    let plan = &probe.run.plan;
    let mut equation = StepEquation::new(&method, &probe.parameters, plan.epsilon, plan.h).ok()?;
    let steps = probe.places.iter().map(|place| {
        let solution = equation.solve(&place.x, &place.solution.y).ok()?;
        Some(solution.increment)
    });
    steps.collect()
}

fn largest(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |largest, (a, b)| distance(a, b).max(largest))
}
