//! Methods whose long steps err no more and take a fraction of the operations.
//!
//! They step in coordinates in which the tensor is constant, or by exact flows of the pieces of H.

use std::sync::Arc;

use leafwise_core::automatic::OverLift;
use leafwise_core::part::{Family, PartInfo, PartKind};
use leafwise_core::{Method, PartParameters, Registry, StepMap, Walk};
use leafwise_scene::compose::ComposedRun;
use leafwise_scene::document::{MethodTable, PartUse};

use super::probe::{distance, size};
use super::stepper::compositions;
use super::{LARGEST, number};

/// The longest step that is tried, in steps of the run, and how often it is taken.
const LONGEST: u64 = 16;
const TIMES: u64 = 4;

/// The tolerance of the solution that errors are measured against, and how many times that its errors may add up to.
const TOLERANCE: f64 = 1e-13;
const FAR: f64 = 100.0;

/// The largest error over how far the motion goes beside which errors of methods are compared: beyond it no method resolves the motion.
const MEANINGLESS: f64 = 0.1;

/// Worth a word is what takes half of the operations or less.
const WORTH: u64 = 2;

/// A method that errs no more than the run's over its first steps, for a fraction of the operations.
#[derive(Clone, Debug, PartialEq)]
pub struct CheaperMethod {
    /// The method.
    pub method: MethodTable,
    /// Its step.
    pub time_step: f64,
    /// Its operations over those of the run's method.
    pub part: f64,
    /// Its largest error over the first steps, and that of the run's method.
    pub errors: [f64; 2],
}

/// `1/4.8 of the operations`, with what was measured.
impl std::fmt::Display for CheaperMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (method, step) = (&self.method, self.time_step);
        let [error, own] = self.errors.map(number);
        let times = 1.0 / self.part;
        let digits = if times < 10.0 { 1 } else { 0 };
        write!(
            f,
            "{method} with time-step = {step:?} takes 1/{times:.digits$} of the operations: over the first {} steps it errs by \
             {error}, this method by {own}",
            TIMES * LONGEST
        )
    }
}

/// The cheapest method in coordinates in which the tensor is constant, or by exact flows of the pieces of H. It takes half of the
/// operations of the run's or less. It errs no more, or by less than 1e-11 of the state. Returns `None` where there is none, for a long lattice,
/// with noise, and for a run of fewer steps than are looked at. Errors as large as the motion tell nothing, and get no word. Nor do steps that
/// keep the energy, and contact motions: other methods step neither at one energy nor at one scale.
pub fn cheaper_method(run: &ComposedRun, registry: &Registry) -> Option<CheaperMethod> {
    let (plan, steps) = (&run.plan, TIMES * LONGEST);
    let is_short = plan.until.is_none() && plan.steps < steps;
    let is_another_motion =
        run.method.noise().is_some() || run.keeps_energy || run.contact.is_some();
    if run.dimension() > LARGEST || is_another_motion || is_short {
        return None;
    }
    let mut tried = over_lifts(run, registry);
    tried.extend(by_flows(run, registry));
    if tried.is_empty() {
        return None;
    }
    let near = registry.reference(Family::Explicit).ok()?;
    let near = near
        .0
        .build(&run.system, &near.1.with("tolerance", TOLERANCE));
    let exact = orbit(run, near.ok()?.as_ref(), 1.0, u64::MAX)?;
    let own = orbit(run, run.method.map(), 1.0, u64::MAX)?;
    let error = |orbit: &Orbit| {
        let states = orbit.states.iter().zip(&exact.states);
        states.fold(0.0_f64, |most, (x, exact)| most.max(distance(x, exact)))
    };
    let largest = exact.states.iter().map(|x| size(x)).fold(0.0, f64::max);
    let own_error = error(&own);
    let start = seen(run, &run.plan.initial);
    let ways = exact.states.iter().map(|x| distance(x, &start));
    let farthest = ways.fold(0.0, f64::max);
    // False where one of them is no number.
    let has_meaning = own_error <= MEANINGLESS * farthest;
    if !has_meaning {
        return None;
    }
    let allowed = own_error.max(FAR * TOLERANCE * largest);
    let mut most = own.operations? / WORTH;
    let mut best = None;
    for (method, map) in tried {
        let mut length = LONGEST as f64;
        while length >= 0.5 {
            let orbit = orbit(run, map.as_ref(), length, most);
            let found = orbit.and_then(|orbit| Some((error(&orbit), orbit.operations?)));
            // Shorter steps take more operations.
            if let Some((error, operations)) = found.filter(|(error, _)| *error <= allowed) {
                most = operations;
                best = Some((method, length, error, operations));
                break;
            }
            length /= 2.0;
        }
    }
    let (method, length, error, operations) = best?;
    let step = length * plan.epsilon * plan.h;
    Some(CheaperMethod {
        method,
        time_step: format!("{step:.12e}").parse().unwrap_or(step),
        part: operations as f64 / own.operations? as f64,
        errors: [error, own_error],
    })
}

/// A method that is tried.
type Tried = (MethodTable, Arc<dyn StepMap>);

fn over_lifts(run: &ComposedRun, registry: &Registry) -> Vec<Tried> {
    let built = |tried: &OverLift| {
        let realization = registry.realization(tried.realization.name).ok()?;
        let realization = realization.build(&run.system, &PartParameters::new());
        let dynamics = registry.dynamics(tried.dynamics.name).ok()?;
        let dynamics = dynamics.build(&PartParameters::of(tried.settings));
        let map = Method::compose(&run.system, realization.ok()?, dynamics.ok()?).ok()?;
        let settings = tried.settings.iter();
        let dynamics = settings.fold(
            PartUse::named(tried.dynamics.name),
            |part, (name, value)| part.with(name, *value),
        );
        let method = MethodTable::pair(PartUse::named(tried.realization.name), dynamics);
        Some((method, Arc::new(map) as Arc<dyn StepMap>))
    };
    registry
        .over_lifts(&run.system)
        .iter()
        .filter_map(built)
        .collect()
}

/// The stepper by exact flows of the pieces of H, for a run over a constant tensor that solves an equation each step. No step is made.
///
/// `None` where it does not fit, and for runs with forces, noise or a pace, of many coordinates or few steps.
pub fn splitting_instead(run: &ComposedRun, registry: &Registry) -> Option<&'static str> {
    let tensor = run.system.expressions()?.tensor();
    let is_constant = tensor.values().all(|entry| entry.variables().is_empty());
    let is_plain = run.method.lattice().is_none()
        && run.method.noise().is_none()
        && run.contact.is_none()
        && run.pace().is_none()
        && !run.system.has_forces();
    let is_short = run.plan.until.is_none() && run.plan.steps < TIMES * LONGEST;
    if !is_constant || !is_plain || is_short || run.dimension() > LARGEST {
        return None;
    }
    let explicit = registry.family(Family::Explicit);
    let parts = run.plan.parts.iter();
    let mut steppers = parts.filter(|part| part.kind == PartKind::Stepper);
    if steppers.any(|part| explicit.iter().any(|info| info.name == part.name)) {
        return None;
    }
    flows(run, registry).map(|(info, _)| info.name)
}

/// The map by exact flows of the pieces of H; none where the run's own is of these.
fn flows(run: &ComposedRun, registry: &Registry) -> Option<(&'static PartInfo, Arc<dyn StepMap>)> {
    let known = registry.family(Family::Splitting);
    let parts = run.plan.parts.iter();
    let mut steppers = parts.filter(|part| part.kind == PartKind::Stepper);
    if steppers.any(|part| known.iter().any(|info| info.name == part.name)) {
        return None;
    }
    let info = *known.first()?;
    let part = registry.stepper(info.name).ok()?;
    let map = part.build(&run.system, &PartParameters::new()).ok()?;
    Some((info, map))
}

/// Flows of the pieces of H and their compositions; none where the run's own are of these.
fn by_flows(run: &ComposedRun, registry: &Registry) -> Vec<Tried> {
    let Some((info, map)) = flows(run, registry) else {
        return Vec::new();
    };
    let method = MethodTable::stepper(PartUse::named(info.name));
    let composed = compositions(registry).into_iter().filter_map(|part| {
        let of = part.build(Arc::clone(&map), &PartParameters::new()).ok()?;
        Some((method.clone().composed(PartUse::named(part.info.name)), of))
    });
    let composed: Vec<Tried> = composed.collect();
    std::iter::once((method, map)).chain(composed).collect()
}

/// The coordinates of a state that errors are measured in: the scene's own, and the time where a pace makes it one of them.
fn seen(run: &ComposedRun, state: &[f64]) -> Vec<f64> {
    let time = run.time_place().map(|place| state[place]);
    run.own(state).iter().copied().chain(time).collect()
}

/// The states of a run's first steps, as they are [`seen`], one for each of the longest, and the operations that they took.
struct Orbit {
    states: Vec<Vec<f64>>,
    operations: Option<u64>,
}

/// By steps of `length` of the run's each; `None` where one fails, and from `most` operations on.
fn orbit(run: &ComposedRun, map: &dyn StepMap, length: f64, most: u64) -> Option<Orbit> {
    let (values, plan) = (run.system.parameter_values(), &run.plan);
    let h = length * plan.h;
    let mut walk = Walk::new(map, &values, plan.epsilon, h, &plan.initial);
    let between = (LONGEST as f64 / length) as u64;
    let mut states = Vec::new();
    for _ in 0..TIMES {
        let is_too_much = |walk: &Walk| {
            let operations = walk.statistics().operations;
            operations
                .is_some_and(|operations| operations >= most)
                .then_some(())
        };
        if walk.watch_until(between, is_too_much).ok()?.is_some() {
            return None;
        }
        states.push(seen(run, walk.state()));
    }
    Some(Orbit {
        states,
        operations: walk.statistics().operations,
    })
}
