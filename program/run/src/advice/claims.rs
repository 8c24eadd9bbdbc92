//! Claims that an orbit belies: what a scene or a library says of its part, and Casimirs that an exact realization keeps.

use leafwise_core::diagnostics::{Defect, TensorDefect, casimir_round_off, casimir_sizes};
use leafwise_core::part::PartKind;
use leafwise_core::{Origin, Registry, StepError, Structure};
use leafwise_scene::compose::ComposedRun;

use super::{Advice, AdviceKind, number};
use crate::invariants::InvariantDrift;

/// Largest [`Defect::relative`] of a step from any state of an orbit that still counts as round-off: solves may be ill
/// conditioned.
const ROUND_OFF: f64 = 64.0 * Defect::ROUND_OFF;

/// Line of the scene to write in place of a part that is not what it says.
const INSTEAD: &str = "realization = \"auto\"";

/// A part that its author says to be exact, whose steps are no Poisson maps at one of the run's states. What this program
/// makes itself is proved, and not looked at.
pub(super) fn advice(
    run: &ComposedRun,
    registry: &Registry,
    states: &[Vec<f64>],
) -> Option<Advice> {
    if run.method.map().properties().structure != Structure::Exact {
        return None;
    }
    let infos = registry.parts();
    let is_written = |name: &str| {
        infos
            .iter()
            .any(|info| info.name == name && info.is_written)
    };
    let mut parts = run.plan.parts.iter();
    let part = parts.find(|part| {
        let is_loaded = matches!(part.origin, Some(Origin::Library { .. }));
        let is_whole = matches!(part.kind, PartKind::Realization | PartKind::Stepper);
        is_whole && (is_loaded || is_written(part.name))
    })?;
    let parameters = run.system.parameter_values();
    let (map, plan) = (run.method.map(), &run.plan);
    let instrument = TensorDefect::new(&run.system, map, &parameters, plan.epsilon, plan.h);
    let mut instrument = instrument.ok()?;
    let mut largest = 0.0_f64;
    for x in states {
        let defect = match instrument.measure(x) {
            Err(StepError::NoTangent) => instrument.measure_by_differences(x),
            measured => measured,
        };
        let Ok(defect) = defect else {
            continue;
        };
        if let (Some(relative), Some(floor)) = (defect.relative(), defect.relative_floor())
            && relative > ROUND_OFF + 4.0 * floor
        {
            largest = largest.max(relative);
        }
    }
    (largest > 0.0).then(|| Advice {
        kind: AdviceKind::BrokenClaim,
        message: format!(
            "{} claims to be exact, but at one of the run's states a step is not a Poisson map: it changes the tensor by \
             {} of its terms",
            part.name,
            number(largest)
        ),
        change: INSTEAD.to_owned(),
    })
}

/// A declared Casimir that moves by more than the round-off of its terms, over a map that keeps it; `invariants` are those
/// of the run, the energy first.
pub(crate) fn casimir_drift(
    run: &ComposedRun,
    invariants: &[InvariantDrift],
    states: &[Vec<f64>],
    steps: u64,
) -> Option<Advice> {
    let structure = run.method.map().properties().structure;
    let is_kept = matches!(structure, Structure::Exact | Structure::Leaves);
    // Events change Casimirs by what they are.
    let has_acts = run.plan.events.act.is_some();
    if !is_kept || has_acts || run.method.lattice().is_some() || invariants.len() < 2 {
        return None;
    }
    let parameters = run.system.parameter_values();
    let sizes = casimir_sizes(&run.system, &parameters, states).ok()?;
    let casimirs = invariants[1..].iter().zip(sizes);
    let excess = |(casimir, size): (&InvariantDrift, f64)| {
        let size = size.max(casimir.initial.abs());
        (casimir.maximum > casimir_round_off(size, steps))
            .then(|| (casimir.name.clone(), casimir.maximum, size))
    };
    let (name, drift, size) = casimirs.map(excess).find_map(|found| found)?;
    let is_stepped = run
        .plan
        .parts
        .iter()
        .any(|part| part.kind == PartKind::Stepper);
    Some(Advice {
        kind: AdviceKind::CasimirDrift,
        message: format!(
            "{name} is a Casimir, and moves by {}, {} of its terms, more than the round-off of {steps} steps that keep it: \
             {} does not do what it declares",
            number(drift),
            number(drift / size),
            run.method.map().describe()
        ),
        change: match is_stepped {
            true => super::step::half_the_step(run),
            false => INSTEAD.to_owned(),
        },
    })
}
