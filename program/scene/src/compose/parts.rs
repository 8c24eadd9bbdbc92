//! Realization and dynamic approximation by name.

use std::sync::Arc;

use leafwise_core::lattice::{LatticeMap, LatticeNumbers};
use leafwise_core::part::{Family, PATH, PartInfo, PartKind};
use leafwise_core::registry::{CompositionPart, StepperPart};
use leafwise_core::system::MotionClass;
use leafwise_core::{
    BuildError, DynamicApproximation, PartParameters, PoissonSystem, RealizationData, Registry,
    StepMap,
};

use super::Refusal;
use super::dense::DENSE_LIMIT;
use super::dense::WRITTEN_LIMIT;
use super::lattice::SceneLattice;
use super::part_choice::PartChoice;
use super::request::{Request, registry_names};
use super::system::{ComposedSystem, written_out};
use crate::document::{Located, Number, SceneDocument};

/// The order of the dynamics that a scene leaves open.
const DEFAULT_DYNAMICS_ORDER: i64 = 4;
/// Order of the dynamics that values alone allow: the default of a system of numbers.
const ORDER_OF_NUMBERS: i64 = 2;

/// Parts that the scene's method is built of: a base and a composition, with the choice of each part.
pub(super) struct Parts {
    pub base: Base,
    pub composition: Option<(CompositionPart, PartParameters)>,
    pub choices: Vec<PartChoice>,
}

/// Base of the method, which is stepped or composed: realization and dynamics, or a stepper.
pub(super) enum Base {
    /// Realization and dynamics.
    Pair(Arc<dyn RealizationData>, Arc<dyn DynamicApproximation>),
    /// A stepper in their place.
    Stepper(Arc<dyn StepMap>),
    /// A stepper that sweeps over a long lattice.
    Sweeps(Box<LatticeMap>),
    /// A stepper without sweeps and the long lattice that it needs written out.
    WrittenOut(Arc<dyn StepMap>, Box<ComposedSystem>),
}

impl Parts {
    /// The dynamic approximation, unless a stepper stands in its place.
    pub fn dynamics(&self) -> Option<Arc<dyn DynamicApproximation>> {
        match &self.base {
            Base::Pair(_, dynamics) => Some(Arc::clone(dynamics)),
            Base::Stepper(_) | Base::Sweeps(_) | Base::WrittenOut(..) => None,
        }
    }

    /// The realization as chosen, for building it again on another lattice.
    pub fn realization(&self) -> Option<&PartChoice> {
        self.choices
            .iter()
            .find(|choice| choice.kind == PartKind::Realization)
    }
}

/// Builds the parts that `[method]` names, for a system or for the long lattice that it stands for.
///
/// A part that is absent or called `auto` is chosen. The dynamics are Hamilton–Jacobi of order 4, or 2 for a system of
/// numbers; where there are forces, the map along leaves. The realization is the exact one that fits the tensor and
/// costs the fewest operations ([`Registry::exact_realization_under`]). Where none fits, or parameters are given with
/// `auto`, it is Karasev's truncated after the dynamics' order. This order is the smallest n for which Theorem 2
/// promises that of the dynamics.
pub(super) fn parts(
    document: &SceneDocument,
    system: &PoissonSystem,
    lattice: Option<&SceneLattice<'_>>,
    registry: &Registry,
) -> Result<Parts, Refusal> {
    let mut choices = Vec::new();
    let base = match &document.method.stepper {
        Some(spec) => {
            let request = Request::new(document, registry, Some(spec), "", 0);
            stepper(&request, system, lattice, registry, &mut choices)?
        }
        None => pair(document, system, lattice.is_some(), registry, &mut choices)?,
    };
    let composition = match &document.method.composition {
        None => None,
        Some(spec) => {
            let request = Request::new(document, registry, Some(spec), "", 0);
            let part = registry
                .composition(request.name())
                .map_err(|_| request.unknown(PartKind::Composition))?;
            let given = request.parameters(part.info)?;
            choices.push(request.choice(part.info, &given, None));
            Some((part, given))
        }
    };
    Ok(Parts {
        base,
        composition,
        choices,
    })
}

/// The part that the scene's system comes from, where it is one of the registry's.
pub(super) fn system_choice(document: &SceneDocument, registry: &Registry) -> Option<PartChoice> {
    let library = document.system.library.as_ref()?;
    let part = registry.system(&library.value).ok()?;
    let info = part.info;
    // A built-in system is a text like the scene's own.
    info.paths.first()?;
    let (given, path) = match &document.system.numbers {
        Some(numbers) => (numbers.given.clone(), "numbers"),
        None => {
            let values = document.system.parameters.iter();
            let with = |given: PartParameters,
                        (name, value): &(Located<String>, Located<Number>)| {
                given.with(name.value.clone(), value.value.value)
            };
            (values.fold(PartParameters::new(), with), "expressions")
        }
    };
    let shown = info.parameters.iter().filter(|p| p.name != PATH).map(|p| {
        let value = given.setting(info, p.name);
        (p.name, value.unwrap_or_else(|_| p.default.into()))
    });
    Some(PartChoice {
        kind: info.kind,
        name: info.name,
        parameters: shown.collect(),
        is_automatic: false,
        reason: None,
        origin: registry.origin(info.name).cloned(),
        path: Some(path),
    })
}

/// Builds the stepper that stands in place of realization and dynamics. Over a long lattice it sweeps. For a stepper
/// without sweeps the lattice is written out, where it is not too long for that.
fn stepper(
    request: &Request<'_>,
    system: &PoissonSystem,
    lattice: Option<&SceneLattice<'_>>,
    registry: &Registry,
    choices: &mut Vec<PartChoice>,
) -> Result<Base, Refusal> {
    let part = registry
        .stepper(request.name())
        .map_err(|_| request.unknown(PartKind::Stepper))?;
    let given = request.parameters(part.info)?;
    let refused = |error| request.refused(&error);
    let base = match lattice {
        None => Base::Stepper(part.build(system, &given).map_err(|error| {
            let mut refusal = request.refused(&error);
            let is_unfit = matches!(error, BuildError::DoesNotFit { .. });
            if let Some(pace) = request.document.method.pace.as_ref().filter(|_| is_unfit) {
                let pace = pace.value.trim();
                refusal.message += &format!(
                    "; with a pace the Hamiltonian is (H + e)*({pace}), where t' = {pace}"
                );
                refusal.help = Some("remove the pace, or a realization and dynamics".to_owned());
            }
            refusal
        })?),
        Some(lattice) => match on_lattice(&part, system, lattice, &given) {
            Ok(map) => Base::Sweeps(Box::new(map)),
            Err(BuildError::DoesNotFit { .. }) if lattice.is_written_for_any() => {
                let composed = written_out(request.document)?;
                let map = part.build(&composed.system, &given).map_err(refused)?;
                Base::WrittenOut(map, Box::new(composed))
            }
            Err(BuildError::DoesNotFit { .. }) if part.info.serves_numbers.is_some() => {
                let map = by_fields(lattice, &part, &given).map_err(refused)?;
                Base::Sweeps(Box::new(map))
            }
            Err(error) => {
                let mut refusal = request.refused(&error);
                match error {
                    BuildError::DoesNotFit { .. } if lattice.has_noise() => {
                        refusal.help = Some("noise moves sites by sweeps: name a stepper that sweeps, or a realization and dynamics".to_owned());
                    }
                    BuildError::DoesNotFit { .. } => {
                        refusal.help = Some(format!(
                            "a lattice of at most {WRITTEN_LIMIT} coordinates is written out for any stepper; for longer ones name \
                             one that sweeps, or a realization and dynamics; {}",
                            of_this_length(registry, system)
                        ));
                    }
                    // Of all that serve such a motion, those that a lattice of this length takes.
                    BuildError::Friction { .. } | BuildError::Forces { .. }
                        if !lattice.is_written_for_any() =>
                    {
                        refusal.message = error.to_string();
                        refusal.help = Some(of_this_length(registry, system));
                    }
                    _ => {}
                }
                return Err(refusal);
            }
        },
    };
    choices.push(request.choice(part.info, &given, part.info.path(&given)));
    Ok(base)
}

/// Steppers that step lattices of any length, as a piece of advice.
fn of_this_length(registry: &Registry, system: &PoissonSystem) -> String {
    let serving = steppers_of_fields(registry, system.motion()).into_iter();
    let names: Vec<&str> = serving.map(|info| info.name).collect();
    let names = names.join(", ");
    match (system.motion(), registry.of_forces()) {
        (MotionClass::OnLeaves, Ok(info)) => format!(
            "dynamics = \"{}\" in the place of `stepper` keeps every Casimir; these take fields alone, on lattices of any length: {names}",
            info.name
        ),
        _ => format!("these take fields alone, on lattices of any length: {names}"),
    }
}

/// Steppers that take fields alone, of such a motion.
pub(super) fn steppers_of_fields(
    registry: &Registry,
    motion: MotionClass,
) -> Vec<&'static PartInfo> {
    let infos = registry.parts().into_iter();
    let serves = |info: &&PartInfo| {
        info.kind == PartKind::Stepper && info.serves_numbers.is_some() && info.takes >= motion
    };
    infos.filter(serves).collect()
}

/// The sweeps of a stepper over a long lattice that `system` stands for.
///
/// # Errors
/// Those of [`StepperPart::build_on_lattice`].
fn on_lattice(
    part: &StepperPart,
    system: &PoissonSystem,
    lattice: &SceneLattice<'_>,
    given: &PartParameters,
) -> Result<LatticeMap, BuildError> {
    system.unless_beyond(part.info.takes, part.info.name)?;
    part.build_on_lattice(lattice, given)
}

/// The map of a stepper that takes fields alone: each is one sweep over the lattice.
///
/// # Errors
/// Those of [`LatticeNumbers::compile`] and of the stepper.
fn by_fields(
    lattice: &SceneLattice<'_>,
    part: &StepperPart,
    given: &PartParameters,
) -> Result<LatticeMap, BuildError> {
    let numbers = LatticeNumbers::compile(lattice)?;
    Ok(LatticeMap {
        map: part.build(&PoissonSystem::from(numbers.system), given)?,
        geometry: numbers.geometry,
        proxy_geometry: numbers.proxy_geometry,
        operations: numbers.operations,
        work: numbers.work,
        fields: numbers.fields,
        swept: None,
    })
}

fn pair(
    document: &SceneDocument,
    system: &PoissonSystem,
    is_lattice: bool,
    registry: &Registry,
    choices: &mut Vec<PartChoice>,
) -> Result<Base, Refusal> {
    let is_open = document.method.dynamics.is_none() || is_lattice;
    if let (Some(friction), true) = (&document.system.forces.friction, is_open) {
        let part = "a realization with a dynamics".to_owned();
        let error = BuildError::Friction { part };
        let (message, help) = match is_lattice && document.system.coordinates() > WRITTEN_LIMIT {
            true => (error.to_string(), Some(of_this_length(registry, system))),
            false => (registry.explain(&error), None),
        };
        let place = friction.place();
        return Err(Box::new(
            document.diagnostic(&place, message, "friction", help),
        ));
    }
    let (default, order) = if system.has_forces() {
        (registry.of_forces().map_or("auto", |info| info.name), 0)
    } else if system.expressions().is_some() {
        (
            of_order(registry, PartKind::Dynamics),
            DEFAULT_DYNAMICS_ORDER,
        )
    } else {
        (of_order(registry, PartKind::Dynamics), ORDER_OF_NUMBERS)
    };
    let request = Request::new(
        document,
        registry,
        document.method.dynamics.as_ref(),
        default,
        order,
    );
    let part = registry
        .dynamics(request.name())
        .map_err(|_| request.unknown(PartKind::Dynamics))?;
    let given = request.parameters(part.info)?;
    let dynamics = part
        .build(&given)
        .map_err(|error| request.refused(&error))?;
    let dynamics_choice = request.choice(part.info, &given, part.info.path(&given));

    let order = i64::try_from(dynamics.properties().order).unwrap_or(DEFAULT_DYNAMICS_ORDER);
    let request = Request::new(
        document,
        registry,
        document.method.realization.as_ref(),
        of_order(registry, PartKind::Realization),
        order,
    );
    let is_open = request.named().is_none() && !request.has_parameters();
    let is_long = document.system.coordinates() > DENSE_LIMIT;
    if let Some((realization, choice)) = is_open
        .then(|| exact_realization(system, registry, &dynamics, is_long))
        .flatten()
    {
        choices.push(choice);
        choices.push(dynamics_choice);
        return Ok(Base::Pair(realization, dynamics));
    }
    let part = registry
        .realization(request.name())
        .map_err(|_| request.unknown(PartKind::Realization))?;
    let given = request.parameters(part.info)?;
    let realization = part.build(system, &given).map_err(|error| {
        let mut refusal = request.refused(&error);
        if matches!(error, BuildError::DoesNotFit { .. }) {
            refusal.help = Some(what_fits(system, registry, dynamics.as_ref(), is_lattice));
        }
        refusal
    })?;
    choices.push(request.choice(part.info, &given, part.info.path(&given)));
    choices.push(dynamics_choice);
    Ok(Base::Pair(realization, dynamics))
}

/// The realizations that fit a system and a dynamic approximation, on a long lattice those that can be
/// swept, as a piece of advice.
pub(super) fn what_fits(
    system: &PoissonSystem,
    registry: &Registry,
    dynamics: &dyn DynamicApproximation,
    is_long: bool,
) -> String {
    let fits = |name: &&str| -> Result<bool, BuildError> {
        let part = registry.realization(name)?;
        let realization = part.build(system, &PartParameters::new())?;
        let bisection = dynamics.bisection(system, &realization)?;
        Ok(!is_long || realization.abilities().stages.is_some() && bisection.code().is_some())
    };
    let names: Vec<&str> = registry_names(registry, PartKind::Realization)
        .into_iter()
        .filter(|name| matches!(fits(name), Ok(true)))
        .collect();
    match (names.as_slice(), is_long) {
        ([], _) => {
            let splits = registry.family(Family::Splitting);
            let such_as = splits
                .first()
                .map_or(String::new(), |part| format!(" such as {}", part.name));
            format!("a stepper{such_as} may replace both")
        }
        (names, true) => format!(
            "these can be swept over a long lattice: {}",
            names.join(", ")
        ),
        (names, false) => format!("these fit: {}", names.join(", ")),
    }
}

/// The exact realization that a choice left open takes, by [`Registry::exact_realization_under`]; on a long lattice, one that can be
/// swept.
pub fn exact_realization(
    system: &PoissonSystem,
    registry: &Registry,
    dynamics: &Arc<dyn DynamicApproximation>,
    is_long: bool,
) -> Option<(Arc<dyn RealizationData>, PartChoice)> {
    let exact = registry.exact_realization_under(dynamics, system, is_long)?;
    let info = exact.info;
    let parameters = info.parameters.iter().map(|p| (p.name, p.default.into()));
    let choice = PartChoice {
        kind: PartKind::Realization,
        name: info.name,
        parameters: parameters.collect(),
        is_automatic: true,
        reason: Some(exact.reason),
        origin: registry.origin(info.name).cloned(),
        path: None,
    };
    Some((exact.realization, choice))
}

/// The part that stands in for one that the scene leaves open, where no exact one fits.
fn of_order(registry: &Registry, kind: PartKind) -> &'static str {
    registry.of_order(kind).map_or("auto", |info| info.name)
}
