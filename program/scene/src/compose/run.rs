//! All of a scene, ready to step.

use std::borrow::Cow;
use std::sync::Arc;

use leafwise_core::LatticeMethod;
use leafwise_core::lattice::LatticeSource;
use leafwise_core::system::SystemObservables;
use leafwise_core::{
    BuildError, Method, MotionClass, Origin, PartKind, PoissonSystem, Registry, StepMap, Structure,
    Walk, WithoutPoles,
};
use leafwise_expression::{Expression, TableFunction};
use leafwise_walk::{Direction, Indicator, SampleTimes, Section, StateLayout};

use super::Refusal;
use super::bodies::many_bodies;
use super::contact::Contact;
use super::definitions::numbers_of_matrices;
use super::events::{Events, check_axes, section_of};
use super::exact_energy::ExactEnergySteps;
use super::extended::{Extension, PaceFormula};
use super::fit::{check_exactness, check_first_order, check_tensor};
use super::functions::CompiledFunctions;
use super::indicators::indicators;
use super::lattice::{SceneLattice, has_room, shortened};
use super::noise::NoisySteps;
use super::observables::Observable;
use super::part_choice::PartChoice;
use super::parts::{Base, Parts, parts, system_choice, what_fits};
use super::request::formula_refusal;
use super::sample_times::{check_given_times, sample_times};
use super::shadow::{RecordedShadow, with_shadows};
use super::states::{RecordedStates, recorded_states};
use super::stepping::{LatticeBase, LatticeStepping, MapStepping, Stepping};
use super::system::{ComposedSystem, compose_system};
use super::tables::tables;
use crate::document::{Located, MatrixNumbers, Number, PartSpec, SceneDocument};

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
    let noise = NoisySteps::of(document, &composed.system, channels, lattice.as_ref())?;
    let exact = ExactEnergySteps::of(document, &composed, lattice.is_some())?;
    let moved = stepped(noise.as_ref(), exact.as_ref(), &composed);
    let own = lattice.as_ref();
    let swept = noise
        .as_ref()
        .and_then(|noise| noise.lattice.as_ref())
        .or(own);
    let mut parts = parts(document, moved, swept, registry)?;
    let choices = parts.choices.clone();
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
            "take the indicators out of the observables",
        ),
        (
            exact.is_some(),
            "exact energy, which would take back what they change",
            "take `energy` out of the method",
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
    let states = recorded_states(document)?;
    check_axes(document, &states, &composed.observables)?;
    let plan = RunPlan {
        epsilon: step.epsilon(),
        h: step.h(),
        step_key: step.key(),
        steps: document.run.steps.value,
        until: document.run.until.as_ref().map(|until| until.value.value),
        samples: sample_times(document),
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
                "it begins at t = 0 and goes the way of its steps: forwards where time-step is positive"
                    .to_owned(),
            ),
        ))),
        None => check_given_times(document),
    }
}

/// Checks the parts of libraries and of the scene's own formulas on the system. A realization is checked by its tensor.
/// The map of the parts is checked by its first order, on a long lattice the map of its short one.
fn check_own_parts(
    (system, near): (&PoissonSystem, &[f64]),
    method: &Stepping,
    choices: &[PartChoice],
    epsilon: f64,
    registry: &Registry,
) -> Result<(), BuildError> {
    let infos = registry.parts();
    let is_written = |name: &str| (infos.iter()).any(|info| info.name == name && info.is_written);
    let is_foreign = |choice: &&PartChoice| {
        matches!(choice.origin, Some(Origin::Library { .. })) || is_written(choice.name)
    };
    let Some(last) = choices.iter().rfind(is_foreign) else {
        return Ok(());
    };
    let built = |choice: &PartChoice| {
        registry
            .realization(choice.name)?
            .build(system, &choice.given())
    };
    let realization = choices.iter().find(|c| c.kind == PartKind::Realization);
    if let Some(choice) = realization.filter(is_foreign) {
        let realization = built(choice)?;
        check_tensor(choice.name, system, &realization, near)?;
        if is_written(choice.name) {
            check_exactness(choice.name, system, &realization, near)?;
        }
    }
    if method.lattice().is_none() {
        return check_first_order(last.name, system, method.map(), epsilon, near);
    }
    let dynamics = choices.iter().find(|c| c.kind == PartKind::Dynamics);
    let (Some(realization), Some(dynamics)) = (realization, dynamics) else {
        return Ok(());
    };
    let dynamics = registry.dynamics(dynamics.name)?.build(&dynamics.given())?;
    let short = Method::compose(system, built(realization)?, dynamics)?;
    check_first_order(last.name, system, &short, epsilon, near)
}

/// The map of parts that are written out.
fn compose_written(system: &PoissonSystem, parts: Parts) -> Result<Stepping, BuildError> {
    let (base, method): (Arc<dyn StepMap>, _) = match parts.base {
        Base::Pair(realization, dynamics) => {
            let method = Method::compose(system, realization, dynamics)?;
            if parts.composition.is_none() {
                return Ok(Stepping::Written(Box::new(method)));
            }
            (Arc::new(method.clone()), Some(Box::new(method)))
        }
        Base::Stepper(map) | Base::WrittenOut(map, _) => (map, None),
        Base::Sweeps(lattice) => (lattice.map, None),
    };
    let is_composed = parts.composition.is_some();
    let map = match parts.composition {
        None => base,
        Some((composition, given)) => composition.build(base, &given)?,
    };
    let map = WithoutPoles::of(system, map)?;
    Ok(Stepping::Map(MapStepping {
        map,
        method,
        is_composed,
        noise: None,
    }))
}

/// The map of a long lattice: a stepper's sweeps, or the chosen parts again, on the proxy their order
/// asks for. The first lattice is the scene's own, the second the same with its noise.
fn compose_lattice(
    (own, lattice): (&SceneLattice<'_>, &SceneLattice<'_>),
    trial: &PoissonSystem,
    parts: Parts,
    registry: &Registry,
) -> Result<LatticeStepping, BuildError> {
    let chosen = parts.realization().cloned();
    let base = match (parts.base, chosen) {
        (Base::Sweeps(map), _) => LatticeBase::Sweeps(map),
        (Base::Pair(_, dynamics), Some(chosen)) => {
            let given = chosen.given();
            let realize =
                |system: &PoissonSystem| registry.realization(chosen.name)?.build(system, &given);
            let method = LatticeMethod::compose(lattice, &realize, dynamics)?;
            LatticeBase::Method(Box::new(method))
        }
        (Base::Pair(..) | Base::Stepper(_) | Base::WrittenOut(..), _) => {
            unreachable!("a long lattice is stepped by sweeps")
        }
    };
    let is_composed = parts.composition.is_some();
    let map = match parts.composition {
        None => base.shared(),
        Some((part, given)) => part.build(base.shared(), &given)?,
    };
    let [invariants, formulas] = own.functions(&trial.parameter_values())?;
    let written = own.own(&base.map().proxy_geometry);
    Ok(LatticeStepping {
        interior: lattice.interior(&base.map().proxy_geometry),
        geometry: own.own(&base.map().geometry),
        written,
        noise: None,
        invariants,
        formulas,
        stepped: WithoutPoles::of_lattice(lattice, map)?,
        is_composed,
        base,
    })
}

impl ComposedRun {
    /// The dimension of the state that is stepped, that of a long lattice at its true length.
    pub fn dimension(&self) -> usize {
        self.method.map().dimension()
    }

    /// The scene's own coordinates of a state that is stepped: all but parameters of sites, the time and its energy.
    pub fn own<'a>(&self, state: &'a [f64]) -> &'a [f64] {
        &state[self.plan.layout.own()]
    }

    /// Whether the state that is stepped holds more than the scene's own coordinates.
    pub fn is_extended(&self) -> bool {
        !self.plan.layout.beside().is_empty()
    }

    /// A surface of its scene, `left = right`, beside the one that it may have itself.
    ///
    /// # Errors
    /// Those of [`section_of`].
    pub fn section(
        &self,
        document: &SceneDocument,
        text: &str,
        direction: Direction,
    ) -> Result<Section, Refusal> {
        let parameters = self.system.parameter_values();
        let is_long = self.method.lattice().is_some();
        let start = (self.plan.initial.as_slice(), parameters.as_slice());
        section_of(document, is_long, start, text, direction)
    }

    /// Where t stands in a state, where steps are of a fictitious time τ.
    pub fn time_place(&self) -> Option<usize> {
        self.pace()?;
        self.plan.layout.clock().map(|clock| clock.time)
    }

    /// e at an initial state, from which H + e is measured, where steps are of a fictitious time τ.
    pub fn origin(&self, initial: &[f64]) -> Option<f64> {
        self.pace()?;
        self.plan.layout.clock().map(|clock| initial[clock.energy])
    }

    /// dt/dτ, where steps are of a fictitious time τ.
    pub fn pace(&self) -> Option<&PaceFormula> {
        self.extension.as_ref()?.pace.as_ref()
    }

    /// A walk at the scene's initial state, with its parameters and step sizes.
    pub fn walk(&self) -> Walk {
        let parameters = self.system.parameter_values();
        let plan = &self.plan;
        Walk::new(
            self.method.map(),
            &parameters,
            plan.epsilon,
            plan.h,
            &plan.initial,
        )
    }

    /// Functions of the state at the parameters' values, compiled once for this run and its copies at other values.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where one has no code.
    pub fn observables(&self, formulas: &[&Expression]) -> Result<SystemObservables, BuildError> {
        self.functions.observables(&self.system, formulas)
    }

    /// The system whose steps are of the time itself, where those of this run are of another.
    pub fn in_time(&self) -> Result<Cow<'_, PoissonSystem>, BuildError> {
        let paced = self.extension.as_ref().filter(|_| self.pace().is_some());
        Ok(match (paced, self.system.expressions()) {
            (Some(extension), Some(formulas)) => {
                let in_time = formulas.with_hamiltonian(extension.energy().clone())?;
                Cow::Owned(in_time.into())
            }
            _ => Cow::Borrowed(&self.system),
        })
    }

    /// Forces and friction by their keys, in the words of an advice: `take system.forces and system.friction out`.
    pub fn without_forces(&self) -> String {
        format!("take {} out", self.force_keys.join(" and "))
    }

    /// Work of forces, of friction, of noise and of contact motions: how they change the energy and the Casimirs, in words. What steps that keep
    /// the energy are. `None` elsewhere.
    pub fn work_of_forces(&self) -> Option<String> {
        if self.keeps_energy {
            return Some(
                "kept to round-off by multiples of Casimirs, each step's own: as a whole it is no Poisson map"
                    .to_owned(),
            );
        }
        if self.contact.is_some() {
            return Some("changes as in every contact motion: dH/dt = -H dH/ds".to_owned());
        }
        let forces = self.system.expressions()?.forces();
        if forces.motion() == MotionClass::OffLeaves {
            let has_forces = !forces.one_form.is_empty() || forces.damping.is_some();
            let energy = match (self.method.noise().is_some(), has_forces) {
                (false, false) => "changes by the friction: dH/dt = <dH, friction>",
                (false, true) => {
                    "changes by the forces and the friction: dH/dt = -<forces, {H, x}> + <dH, friction>"
                }
                (true, false) => "changes by the noise and the friction",
                (true, true) => "changes by the noise, the forces and the friction",
            };
            let map = match self.system.casimir_names().is_empty() {
                true => "no Poisson map: the friction changes the tensor",
                false => {
                    "no Poisson map: the Casimirs change by the friction, dC/dt = <dC, friction>"
                }
            };
            return Some(format!("{energy}; {map}"));
        }
        let energy = match (forces.one_form.is_empty(), &forces.damping) {
            (true, None) if self.method.noise().is_some() => "changes by the noise",
            (false, _) | (_, Some(_)) if self.method.noise().is_some() => {
                "changes by the noise and the forces"
            }
            (true, None) => return None,
            (true, Some(damping)) if damping.rate.variables().is_empty() => {
                "falls by the damping: dH/dt = -rate <g v, v> with v = {H, x}"
            }
            (true, Some(_)) => "changes by the damping: dH/dt = -rate <g v, v> with v = {H, x}",
            (false, _) => "changes by the forces: dH/dt = -<forces, {H, x}>",
        };
        let has_casimirs = !self.system.casimir_names().is_empty();
        let casimirs = match self.method.map().properties().structure {
            _ if !has_casimirs => "",
            Structure::Leaves | Structure::Exact => "; Casimirs are kept to round-off",
            _ => "; these steps keep Casimirs to an order alone",
        };
        Some(format!("{energy}{casimirs}"))
    }

    /// The names of the scene's own coordinates.
    pub fn names(&self) -> Vec<String> {
        match self.method.lattice() {
            None => {
                let mut names = self.system.variables().to_vec();
                names.truncate(self.plan.layout.coordinates());
                names
            }
            Some(geometry) => (self.plan.layout.own())
                .map(|coordinate| geometry.name(coordinate))
                .collect(),
        }
    }
}

/// Parts that do not fit each other or the system.
fn method_refusal(document: &SceneDocument, registry: &Registry, error: &BuildError) -> Refusal {
    let hamiltonian = &document.system.hamiltonian;
    let formula = document.place_in_formula(hamiltonian, 0..hamiltonian.value.len());
    let part = |spec: &Option<PartSpec>| spec.as_ref().map(|spec| spec.name.place());
    let method = &document.method;
    let named = |name: &str| {
        let specs = [&method.realization, &method.dynamics, &method.stepper];
        let spec = specs
            .into_iter()
            .flatten()
            .find(|spec| spec.name.value == name);
        spec.map(|spec| spec.name.place())
    };
    let mut specs = [&method.realization, &method.dynamics]
        .into_iter()
        .flatten();
    if let Some(refusal) = specs.find_map(|spec| formula_refusal(document, spec, error)) {
        return refusal;
    }
    let place = match error {
        BuildError::Algebra(_) => formula,
        BuildError::NotComposable { .. }
        | BuildError::NoFactors { .. }
        | BuildError::Pieces { .. } => part(&document.method.composition)
            .unwrap_or_else(|| document.system.hamiltonian.place()),
        BuildError::DoesNotFit { part: name, .. }
        | BuildError::NotMade { part: name, .. }
        | BuildError::Formula { part: name, .. }
            if named(name).is_some() =>
        {
            named(name).unwrap_or(formula)
        }
        _ => part(&document.method.dynamics)
            .or_else(|| part(&document.method.stepper))
            .or_else(|| part(&document.method.realization))
            .unwrap_or(formula),
    };
    Box::new(document.diagnostic(&place, registry.explain(error), "here", None))
}
