//! All of a scene, ready to step.

use std::sync::Arc;

use leafwise_core::lattice::LatticeSource;
use leafwise_core::{BuildError, PoissonSystem, Registry, StepMap, SystemFormulas};
use leafwise_expression::TableFunction;
use leafwise_walk::{Indicator, SampleTimes, StateLayout};

use super::Refusal;
use super::bodies::many_bodies;
use super::contact::Contact;
use super::definitions::numbers_of_matrices;
use super::events::{Events, check_axes};
use super::exact_energy::ExactEnergySteps;
use super::extended::Extension;
use super::functions::CompiledFunctions;
use super::indicators::indicators;
use super::kicks::check_kicks;
use super::lattice::{SceneLattice, has_room, shortened};
use super::method::{check_own_parts, compose_lattice, compose_written, method_refusal};
use super::noise::NoisySteps;
use super::observables::{Observable, check_spins};
use super::one_length::check_length;
use super::part_choice::PartChoice;
use super::parts::{Base, parts, system_choice, what_fits};
use super::sample_times::{check_given_times, sample_times};
use super::shadow::{RecordedShadow, with_shadows};
use super::sites::Sites;
use super::states::{RecordedStates, recorded_states};
use super::stepping::{LatticeStepping, Stepping};
use super::system::{ComposedSystem, compose_system};
use super::tables::tables;
use crate::document::{Located, MatrixNumbers, Number, SceneDocument};

/// Plan of a run: its step, length, initial state, records and parts.
#[derive(Clone, Debug)]
pub struct RunPlan {
    /// ε.
    pub epsilon: f64,
    /// h.
    pub h: f64,
    /// The scene's key that sets how long a step is: `time-step`, or `h` beside `epsilon`.
    pub step_key: &'static str,
    /// The number of steps.
    pub steps: u64,
    /// The time at the end, in place of a number of steps.
    pub until: Option<f64>,
    /// When samples are kept.
    pub samples: SampleTimes,
    /// Every how many steps energy and Casimirs are looked at.
    pub drift_every: u64,
    /// x_0, as its [`layout`](Self::layout) has it.
    pub initial: Vec<f64>,
    /// Observables that a sample holds beside time and state.
    pub observables: Vec<Observable>,
    /// Which of them is the energy of the map's shadow.
    pub shadow: Option<RecordedShadow>,
    /// Indicators of chaos among them, in their order.
    pub indicators: Vec<Indicator>,
    /// Events watched between the steps.
    pub events: Events,
    /// Layout of a state that is stepped.
    pub layout: StateLayout,
    /// Files that values of sites and tables are read from.
    pub files: Vec<String>,
    /// The tables that formulas call.
    pub tables: Vec<TableFunction>,
    /// The numbers of matrices of couplings, row after row.
    pub matrices: Vec<MatrixNumbers>,
    /// The coordinates that are recorded.
    pub states: RecordedStates,
    /// Realization and dynamics as chosen.
    pub parts: Vec<PartChoice>,
    /// The part that the system comes from, where it is one of the registry's.
    pub system: Option<PartChoice>,
    /// The scene's families with their lengths.
    pub families: Vec<(String, usize)>,
    /// Their sites, as pictures show them.
    pub sites: Sites,
}

/// A scene with its system and method built.
#[derive(Clone)]
pub struct ComposedRun {
    /// (M, π, H); for a long lattice, its system on the short one that its templates come from.
    pub system: PoissonSystem,
    /// A state of `system` near the initial one.
    pub near: Vec<f64>,
    /// The time as a coordinate, where H names it: two coordinates of `system` behind the scene's own.
    pub extension: Option<Extension>,
    /// The scale of a contact form as the last coordinate of `system`, where the bracket is one.
    pub contact: Option<Contact>,
    /// The map on `system` whose steps are brought back to scale 1, where the bracket is a contact bracket.
    pub homogeneous: Option<Arc<dyn StepMap>>,
    /// Whether each step takes multiples of Casimirs of its own, with which it keeps the energy.
    pub keeps_energy: bool,
    /// The method.
    pub method: Stepping,
    /// From where, how far, what to keep.
    pub plan: RunPlan,
    /// The keys of the scene that give forces and friction.
    pub force_keys: Vec<&'static str>,
    /// Tensor and forces of one site of many bodies, whose sums over pairs are taken in loops.
    pub site: Option<SystemFormulas>,
    pub(super) functions: CompiledFunctions,
}

/// Builds the system and the method of a scene.
///
/// # Errors
/// The first thing wrong, underlined in the scene.
pub fn compose(document: &SceneDocument, registry: &Registry) -> Result<ComposedRun, Refusal> {
    let mut run = compose_at_its_values(document, registry)?;
    if let Some(elsewhere) = chosen_at(document)? {
        let chosen = compose_at_its_values(&elsewhere, registry)?;
        run.plan.parts = chosen.plan.parts;
        run.method = match (run.method, chosen.method) {
            // Observers are of the parameters' own values.
            (Stepping::Lattice(own), Stepping::Lattice(chosen)) => {
                Stepping::Lattice(Box::new(LatticeStepping {
                    invariants: own.invariants,
                    formulas: own.formulas,
                    ..*chosen
                }))
            }
            (_, chosen) => chosen,
        };
    }
    Ok(run)
}

/// The scene at the values that its method is chosen at, where it names any.
fn chosen_at(document: &SceneDocument) -> Result<Option<SceneDocument>, Refusal> {
    let given = &document.method.chosen_at;
    if given.is_empty() || document.system.numbers.is_some() {
        return Ok(None);
    }
    let mut elsewhere = document.clone();
    for (name, value) in given {
        let mut declared = elsewhere.system.parameters.iter_mut();
        match declared.find(|(known, _)| known.value == name.value) {
            Some((_, entry)) => *entry = value.clone(),
            None => {
                return Err(Box::new(document.diagnostic(
                    &name.place(),
                    format!("the system has no parameter `{}`", name.value),
                    "not a parameter",
                    None,
                )));
            }
        }
    }
    Ok(Some(elsewhere))
}

/// The same with the method chosen at the values of the parameters.
fn compose_at_its_values(
    document: &SceneDocument,
    registry: &Registry,
) -> Result<ComposedRun, Refusal> {
    check_times(document)?;
    let (mut composed, lattice) = match many_bodies(document, registry)? {
        Some(bodies) => (bodies, None),
        None => (compose_system(document)?, SceneLattice::of(document)?),
    };
    let channels = std::mem::take(&mut composed.noise);
    let beside = (lattice.as_ref(), composed.bodies.as_ref());
    let noise = NoisySteps::of(document, &composed.system, channels, beside)?;
    let exact = ExactEnergySteps::of(document, &composed, lattice.is_some())?;
    let moved = stepped(noise.as_ref(), exact.as_ref(), &composed);
    let own = lattice.as_ref();
    let swept = noise
        .as_ref()
        .and_then(|noise| noise.lattice.as_ref())
        .or(own);
    let mut parts = parts(document, moved, swept, registry)?;
    let choices = parts.choices.clone();
    check_length(document, &choices)?;
    let dynamics = parts.dynamics();
    if let Base::WrittenOut(map, whole) = parts.base {
        composed = *whole;
        parts.base = Base::Stepper(map);
    }
    let is_long = lattice.is_some();
    let refused = |composed: &ComposedSystem, error: &BuildError| {
        let mut refusal = method_refusal(document, registry, error);
        if let (BuildError::Incompatible { .. } | BuildError::LiftAlone { .. }, Some(dynamics)) =
            (error, &dynamics)
        {
            refusal.help = Some(what_fits(
                &composed.system,
                registry,
                dynamics.as_ref(),
                is_long,
            ));
        }
        refusal
    };
    let method = match (own.zip(swept), &parts.base) {
        (Some(lattices), Base::Pair(..) | Base::Sweeps(_)) => {
            compose_lattice(lattices, &composed.system, parts, registry)
                .map(|stepping| Stepping::Lattice(Box::new(stepping)))
        }
        _ => compose_written(stepped(noise.as_ref(), exact.as_ref(), &composed), parts),
    };
    let mut method = method.map_err(|error| refused(&composed, &error))?;
    if let (Stepping::Lattice(stepping), Some(own)) = (&method, own) {
        let map = stepping.base.map();
        let written = own.write_out(&stepping.written);
        composed.system = written.map_err(|error| refused(&composed, &error))?;
        has_room(document, map.geometry.dimension(), map.fields)?;
        composed.near = shortened(&composed.initial, &stepping.geometry, &stepping.written);
    }
    let step = &document.method.step;
    let fits = check_own_parts(
        (
            stepped(noise.as_ref(), exact.as_ref(), &composed),
            &composed.near,
        ),
        &method,
        &choices,
        step.epsilon(),
        registry,
    );
    fits.map_err(|error| refused(&composed, &error))?;
    if let Some(noise) = &noise {
        method = noise.enter(document, registry, method)?;
    }
    if let Some(exact) = &exact {
        method = exact.enter(document, &composed.system, method)?;
    }
    let mut homogeneous = None;
    if let Some(contact) = &composed.contact {
        let (map, entered) = contact.enter(method);
        (homogeneous, method) = (Some(map), entered);
    }
    let system = &composed.system;
    check_spins(document, system, &composed.observables)?;
    let shadow = with_shadows(document, system, &method, &mut composed.observables)?;
    let indicators = indicators(
        document,
        &composed.observables,
        &method,
        (step.epsilon(), step.h()),
        (system, &composed.initial),
    )?;
    let section = document.run.section.as_ref();
    let beside = [
        (
            !indicators.is_empty(),
            "indicators of chaos",
            "remove the indicators from the observables",
        ),
        (
            exact.is_some(),
            "exact energy, which would undo their change",
            "remove `energy` from the method",
        ),
    ];
    if let Some(set) = section.and_then(|section| section.set.as_ref())
        && let Some((_, what, help)) = beside.into_iter().find(|(is_there, ..)| *is_there)
    {
        return Err(Box::new(document.diagnostic(
            &set.place(),
            format!("events that change the state are not offered with {what}"),
            "here",
            Some(help.to_owned()),
        )));
    }
    let layout = composed.layout(document);
    let parameters = system.parameter_values();
    let start = (composed.initial.as_slice(), parameters.as_slice());
    check_kicks(document, &composed.events, layout.clock(), start)?;
    let states = recorded_states(document)?;
    check_axes(document, &states, &composed.observables)?;
    let plan = RunPlan {
        epsilon: step.epsilon(),
        h: step.h(),
        step_key: step.key(),
        steps: document.run.steps.value,
        until: document.run.until.as_ref().map(|until| until.value.value),
        samples: sample_times(document),
        drift_every: document.run.record.drift_every,
        initial: composed.initial,
        layout,
        files: document.files(),
        tables: tables(document)?,
        matrices: numbers_of_matrices(document)?,
        observables: composed.observables,
        shadow,
        indicators,
        events: composed.events,
        states,
        sites: Sites::of(document),
        parts: choices,
        system: system_choice(document, registry),
        families: document
            .system
            .moving()
            .iter()
            .map(|(name, length)| (name.value.clone(), length.value))
            .collect(),
    };
    Ok(ComposedRun {
        force_keys: document.system.forces.keys(),
        site: composed.bodies.map(|bodies| bodies.site),
        system: composed.system,
        near: composed.near,
        extension: composed.extension,
        contact: composed.contact,
        homogeneous,
        keeps_energy: exact.is_some(),
        method,
        plan,
        functions: CompiledFunctions::default(),
    })
}

/// The system whose steps the parts make.
fn stepped<'a>(
    noise: Option<&'a NoisySteps>,
    exact: Option<&'a ExactEnergySteps>,
    composed: &'a ComposedSystem,
) -> &'a PoissonSystem {
    match (noise, exact) {
        (Some(noise), _) => &noise.stepped,
        (None, Some(exact)) => &exact.stepped,
        (None, None) => &composed.system,
    }
}

/// Times lie ahead of the run.
pub(super) fn check_times(document: &SceneDocument) -> Result<(), Refusal> {
    // Neither number is NaN.
    let never =
        |until: &&Located<Number>| until.value.value * document.method.step.time_step() <= 0.0;
    match document.run.until.as_ref().filter(never) {
        Some(until) => Err(Box::new(document.diagnostic(
            &until.place(),
            format!("the run never comes to t = {}", until.value.literal),
            "here",
            Some(
                "it begins at t = 0 and follows the sign of time-step: forwards where it is positive"
                    .to_owned(),
            ),
        ))),
        None => check_given_times(document),
    }
}
