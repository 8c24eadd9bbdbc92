//! Steppers that stand in place of realization and dynamics: one that is no Poisson map where
//! splitting would be one for no more, and stages that a step cannot feel.

use std::sync::Arc;

use leafwise_core::diagnostics::{Defect, TensorDefect};
use leafwise_core::part::{Family, ParameterSetting, PartKind};
use leafwise_core::registry::CompositionPart;
use leafwise_core::{PartParameters, Pieces, Registry, StepMap, Structure};

use super::motion::increment;
use super::probe::{distance, given, size};
use super::trial::Trial;
use super::truncation::{FELT, ROUND_OFF};
use super::{Advice, AdviceKind, number};
use leafwise_scene::compose::{ComposedRun, PartChoice};

/// The tolerance of the solution that errors are measured against.
const TOLERANCE: f64 = 1e-13;
/// How many times its tolerance that solution's errors may add up to.
const FAR: f64 = 100.0;

/// One stage less may or may not be told from round-off: worth a word are two.
const LEAST_SAVING: i64 = 2;

/// Units of round-off in a stage's part of an increment: a field of some operations, a weight, a sum.
const OF_A_STAGE: f64 = 4.0;

/// Advice about a run's stepper; none where there is no stepper.
pub(super) fn advice(run: &ComposedRun, registry: &Registry, states: &[Vec<f64>]) -> Vec<Advice> {
    let part = |kind| run.plan.parts.iter().find(|part| part.kind == kind);
    // Of a long lattice the system is that of a short one.
    let is_whole = run.system.dimension() == run.dimension();
    let Some(stepper) = part(PartKind::Stepper).filter(|_| is_whole) else {
        return Vec::new();
    };
    let is_composed = part(PartKind::Composition).is_some();
    let stages = (!is_composed).then(|| stages(run, registry, stepper, states));
    let structure = structure(run, registry, stepper, states);
    structure.into_iter().chain(stages.flatten()).collect()
}

/// A step that is no Poisson map, where splitting or a composition of it is one.
fn structure(
    run: &ComposedRun,
    registry: &Registry,
    stepper: &PartChoice,
    states: &[Vec<f64>],
) -> Option<Advice> {
    let map = run.method.map();
    // The tensor of a contact scene is that of its homogeneous system.
    if map.properties().structure == Structure::Exact || run.contact.is_some() {
        return None;
    }
    let defect = defect(run, states);
    // A constant tensor is kept by methods that keep no other.
    if defect.is_some_and(|defect| defect <= Defect::ROUND_OFF) {
        return None;
    }
    let all = || states.iter().map(Vec::as_slice);
    let first = || all().take(1);
    let now = Trial::of(run, map, all())?;
    let splits = registry.family(Family::Splitting).first()?.name;
    let part = registry.stepper(splits).ok()?;
    let splitting = part.build(&run.system, &PartParameters::new()).ok()?;
    let composed = compositions(registry).into_iter().filter_map(|part| {
        let map = part.build(Arc::clone(&splitting), &PartParameters::new());
        Some((Some(part.info.name), map.ok()?))
    });
    let mut maps = std::iter::once((None, Arc::clone(&splitting))).chain(composed);
    let (near, given) = registry.reference(Family::Explicit).ok()?;
    let near = near.build(&run.system, &given.with("tolerance", TOLERANCE));
    let exact = Trial::of(run, near.ok()?.as_ref(), first())?.state;
    let error = |trial: &Trial| distance(&trial.state, &exact);
    let (composition, then) = maps.find_map(|(name, map)| {
        let then = Trial::instead(run, map.as_ref(), all(), &now)?;
        let is_as_good = error(&then) <= error(&now).max(FAR * TOLERANCE * size(&exact));
        (then.is_as_cheap(&now) && is_as_good).then_some((name, then))
    })?;
    let name = match composition {
        None => splits.to_owned(),
        Some(composition) => format!("{composition} of {splits}"),
    };
    let kept = match defect {
        Some(defect) => format!("keeps the tensor up to {} of its size only", number(defect)),
        None => "does not keep the tensor".to_owned(),
    };
    let line = composition.map_or_else(String::new, |name| format!("\ncomposition = \"{name}\""));
    Some(Advice {
        kind: AdviceKind::NoPoissonMap,
        message: format!(
            "{} is not a Poisson map, a step of it {kept}; {name} is one, and takes {:.0} operations a \
             step where this takes {:.0}",
            stepper.name, then.operations, now.operations
        ),
        change: format!("stepper = \"{splits}\"{line}"),
    })
}

/// The compositions that are tried, the best one of each order with and without factors, the cheapest
/// first.
pub(super) fn compositions(registry: &Registry) -> Vec<CompositionPart> {
    let parts = registry.compared(PartKind::Composition).into_iter();
    let mut parts: Vec<CompositionPart> = parts
        .filter_map(|info| registry.composition(info.name).ok())
        .collect();
    // Those for pieces of a kind are for `tune` to try.
    parts.retain(|part| part.factors.is_none_or(|pieces| pieces == Pieces::Any));
    // Sorts are stable: the best of an order stays in front of the others.
    parts.sort_by_key(|part| (part.order, part.factors.is_some()));
    parts.dedup_by_key(|part| (part.order, part.factors.is_some()));
    parts
}

/// The largest tensor defect of a step, relative; `None` where there is no tangent.
fn defect(run: &ComposedRun, states: &[Vec<f64>]) -> Option<f64> {
    let values = run.system.parameter_values();
    let (epsilon, h) = (run.plan.epsilon, run.plan.h);
    let map = run.method.map();
    let mut instrument = TensorDefect::new(&run.system, map, &values, epsilon, h).ok()?;
    let mut largest = 0.0_f64;
    for x in states {
        largest = largest.max(instrument.measure(x).ok()?.relative()?);
    }
    Some(largest)
}

/// Stages of a Gauss method that no step feels.
fn stages(
    run: &ComposedRun,
    registry: &Registry,
    stepper: &PartChoice,
    states: &[Vec<f64>],
) -> Option<Advice> {
    let stages = stepper
        .parameters
        .iter()
        .find_map(|(name, value)| match value {
            ParameterSetting::Integer(stages) if *name == "stages" => Some(*stages),
            _ => None,
        })?;
    let part = registry.stepper(stepper.name).ok()?;
    let whole = increments(run, run.method.map(), states)?;
    let rounded = OF_A_STAGE * stages as f64 * ROUND_OFF;
    let mut enough = stages;
    while enough > 1 {
        let fewer = given(stepper).with("stages", enough - 1);
        let Ok(map) = part.build(&run.system, &fewer) else {
            break;
        };
        let Some(fewer) = increments(run, map.as_ref(), states) else {
            break;
        };
        let mut pairs = states.iter().zip(whole.iter().zip(&fewer));
        let is_same = pairs.all(|(x, (whole, fewer))| {
            distance(whole, fewer) <= rounded * size(whole) + FELT * size(x)
        });
        if !is_same {
            break;
        }
        enough -= 1;
    }
    // What fewer stages leave has a sign and adds up, unlike round-off: one more makes it smaller by
    // another power of the step.
    let enough = enough + 1;
    let name = stepper.name;
    (enough + LEAST_SAVING <= stages).then(|| Advice {
        kind: AdviceKind::Stages,
        message: format!(
            "{name} of {stages} stages: at the run's states {enough} give the same step to round-off"
        ),
        change: format!("stepper = {{ name = \"{name}\", stages = {enough} }}"),
    })
}

/// x_{k+1} − x_k from each state.
fn increments(run: &ComposedRun, map: &dyn StepMap, states: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let each = states.iter().map(|x| increment(run, map, x).ok());
    each.collect()
}
