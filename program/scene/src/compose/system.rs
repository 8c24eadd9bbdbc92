//! The Poisson system of a scene, with its initial state.

use std::collections::BTreeSet;

use leafwise_core::PoissonSystem;
use leafwise_core::lattice::LatticeSource;
use leafwise_walk::StateLayout;

use super::Refusal;
use super::channels::Channel;
use super::contact::{Contact, check_short};
use super::definitions::scope;
use super::events::{Events, events};
use super::extended::Extension;
use super::forces::{check_forces, check_metric_of_sites};
use super::geometry::geometry;
use super::initial::initial_state;
use super::instantiate::instantiate;
use super::lattice::{SceneLattice, has_forms, shortened};
use super::lattice_noise::site_channels;
use super::names::{check_names, parse};
use super::observables::{Observable, observables};
use super::site_forces::Bodies;
use super::time::check_begin;
use crate::document::{InitialSpec, Located, SceneDocument};

/// A scene's system and where it starts.
#[derive(Clone, Debug)]
pub struct ComposedSystem {
    /// (M, π, H) with Casimirs and parameters.
    pub system: PoissonSystem,
    /// x_0, with the time and its energy behind it where there is an [`extension`](Self::extension).
    pub initial: Vec<f64>,
    /// The time as a coordinate, where H names it.
    pub extension: Option<Extension>,
    /// The scale of a contact form as a coordinate, 1 in every state, where the bracket is one.
    pub contact: Option<Contact>,
    /// Channels of noise, which move the system at random.
    pub noise: Vec<Channel>,
    /// Forces and noise beside sums over pairs that are taken in loops.
    pub bodies: Option<Bodies>,
    /// Observables that the run records.
    pub observables: Vec<Observable>,
    /// Events that the run watches between its steps.
    pub events: Events,
    /// A state of `system` near the initial one: `initial` itself, or the same on the short lattice
    /// that stands for a long one.
    pub near: Vec<f64>,
}

/// Reads the formulas of a scene.
///
/// # Errors
/// The first thing wrong, underlined in the scene.
pub fn compose_system(document: &SceneDocument) -> Result<ComposedSystem, Refusal> {
    check_contradictions(document)?;
    check_names(document)?;
    check_sites(document)?;
    let varied = document.ensemble.iter().flat_map(|own| &own.parameters);
    let varied: Vec<&str> = varied.map(|(name, _)| name.value.as_str()).collect();
    check_varied(document, &varied, false)?;
    if let Some(numbers) = &document.system.numbers {
        if let Some(pace) = &document.method.pace {
            return Err(Box::new(document.diagnostic(
                &pace.place(),
                "a pace needs the formulas of the system, and this one offers only numbers",
                "here",
                Some("take steps that are short enough everywhere".to_owned()),
            )));
        }
        let initial = initial_state(document)?;
        let system = PoissonSystem::clone(&numbers.system);
        let scope = scope(document, &geometry(document), None)?;
        let events = events(document, &scope)?;
        events.check(document, &initial, &system.parameter_values())?;
        return Ok(ComposedSystem {
            system,
            near: initial.clone(),
            initial,
            extension: None,
            contact: None,
            noise: Vec::new(),
            bodies: None,
            observables: observables(document, &scope, None)?,
            events,
        });
    }
    let lattice = SceneLattice::of(document)?;
    check_short(document, lattice.is_some())?;
    if let Some(lattice) = lattice {
        let (system, geometry, observables) = lattice.trial()?;
        let initial = initial_state(document)?;
        let whole = scope(document, lattice.geometry(), None)?;
        let events = events(document, &whole)?;
        events.check(document, &initial, &system.parameter_values())?;
        let near = shortened(&initial, lattice.geometry(), &geometry);
        check_forces(document, &system, &near)?;
        let at_start = (initial.as_slice(), &*system.parameter_values());
        check_metric_of_sites(document, &whole, at_start, lattice.geometry())?;
        return Ok(ComposedSystem {
            noise: site_channels(document, &lattice.own(&geometry))?,
            system,
            initial,
            extension: None,
            contact: None,
            bodies: None,
            observables,
            events,
            near,
        });
    }
    written_out(document)
}

/// Refuses keys of different tables that do not stand beside one another.
pub(super) fn check_contradictions(document: &SceneDocument) -> Result<(), Refusal> {
    match document.contradiction() {
        None => Ok(()),
        Some(refusal) => Err(Box::new(refusal)),
    }
}

/// Refuses parameters of sites beside a bracket that is an inverse, which would have none with them.
pub(super) fn check_sites(document: &SceneDocument) -> Result<(), Refusal> {
    let system = &document.system;
    if let Some((key, _)) = system.sites.first()
        && has_forms(&system.bracket.value, &system.constraints)
    {
        return Err(Box::new(
            document.diagnostic(
                &key.place(),
                "parameters of sites are not supported with a bracket by a form or with constraints",
                "here",
                Some(
                    "write the bracket's entries, or a number for each site where it is used"
                        .to_owned(),
                ),
            ),
        ));
    }
    Ok(())
}

/// Refuses values of sites, and an initial state where the trajectories `begin_there`, that are formed once of a parameter that
/// has another value for each.
///
/// # Errors
/// The first formula that names one of `varied`, or a formula that cannot be read.
pub fn check_varied(
    document: &SceneDocument,
    varied: &[&str],
    begin_there: bool,
) -> Result<(), Refusal> {
    let system = &document.system;
    let fields = system.sites.iter().map(|(_, field)| field);
    let matrices = system.matrices.iter().map(|matrix| &matrix.field);
    let initial: &[_] = match &document.run.initial.value {
        InitialSpec::Fields(fields) if begin_there => fields,
        _ => &[],
    };
    let initial = initial
        .iter()
        .map(|(_, field)| ("the initial state is", field));
    let sites = fields
        .chain(matrices)
        .map(|field| ("values of sites are", field));
    for (what, field) in sites.chain(initial) {
        let Some(formula) = field.formula() else {
            continue;
        };
        let names = names_behind(document, formula)?;
        let Some(name) = varied.iter().find(|name| names.contains(**name)) else {
            continue;
        };
        let help = match what.starts_with("values") {
            true => format!("multiply by `{name}` in the Hamiltonian"),
            false => format!(
                "give each its own initial state, or write a number in the place of `{name}`"
            ),
        };
        return Err(Box::new(document.diagnostic(
            &document.place_in_formula(formula, 0..formula.value.len()),
            format!("{what} formed once, and `{name}` varies"),
            "of a parameter that varies",
            Some(help),
        )));
    }
    Ok(())
}

/// The names of a formula, and of the definitions that it uses.
fn names_behind(
    document: &SceneDocument,
    formula: &Located<String>,
) -> Result<BTreeSet<String>, Refusal> {
    let mut found = BTreeSet::new();
    let mut waiting = vec![formula];
    while let Some(formula) = waiting.pop() {
        for name in parse(document, formula)?.references() {
            if found.insert(name.to_owned()) {
                let define = document.system.define.iter();
                let own = define.filter(|(known, _)| known.value == name);
                waiting.extend(own.map(|(_, formula)| formula));
            }
        }
    }
    Ok(found)
}

impl ComposedSystem {
    /// Layout of a state that is stepped.
    pub fn layout(&self, document: &SceneDocument) -> StateLayout {
        let system = &document.system;
        let sites = system.dimension() - system.coordinates();
        StateLayout::new(system.coordinates(), sites)
            .with_clock(self.extension.is_some())
            .with_scale(self.contact.is_some())
    }
}

/// An initial state with what is stepped beside it: the time with its energy, and the scale of a contact form.
///
/// # Errors
/// Those of a pace that is not positive there, and of an energy that is not finite.
pub(super) fn with_beside(
    document: &SceneDocument,
    initial: Vec<f64>,
    (extension, contact): (Option<&Extension>, Option<&Contact>),
    parameters: &[f64],
) -> Result<Vec<f64>, Refusal> {
    let mut initial = match extension {
        Some(extension) => extension.state(document, &initial, parameters)?,
        None => initial,
    };
    initial.extend(contact.map(|_| 1.0));
    Ok(initial)
}

/// The system with its families written out at their true lengths.
///
/// # Errors
/// As [`compose_system`].
pub(super) fn written_out(document: &SceneDocument) -> Result<ComposedSystem, Refusal> {
    let mut instantiated = instantiate(document, &geometry(document))?;
    let observables = std::mem::take(&mut instantiated.observables);
    let mut events = std::mem::take(&mut instantiated.events);
    let forms = std::mem::take(&mut instantiated.forms);
    let extension = instantiated.extension.take();
    let contact = instantiated.contact.take();
    let noise = std::mem::take(&mut instantiated.noise);
    let system = instantiated.system(document).map_err(|error| {
        document.diagnostic(
            &document.system.bracket.place(),
            error.to_string(),
            "here",
            None,
        )
    })?;
    let initial = initial_state(document)?;
    let stepped_beside = (extension.as_ref(), contact.as_ref());
    let initial = with_beside(
        document,
        initial,
        stepped_beside,
        &system.parameter_values(),
    )?;
    if let Some(extension) = &extension {
        check_begin(document, &system, &initial, extension.clock.time)?;
    }
    events.check(document, &initial, &system.parameter_values())?;
    events.look_at_tensor(document, &system, &initial);
    check_forces(document, &system, &initial)?;
    let system = system.with_near(&initial).unwrap_or(system);
    let system = forms.apply(document, system)?;
    Ok(ComposedSystem {
        system,
        near: initial.clone(),
        initial,
        extension,
        contact,
        noise,
        bodies: None,
        observables,
        events,
    })
}
