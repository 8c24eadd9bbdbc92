//! The method of the chosen parts: its map, checks of parts from outside, and what is said of parts that do not fit.

use std::sync::Arc;

use leafwise_core::{
    BuildError, LatticeMethod, Method, Origin, PartKind, PoissonSystem, Registry, StepMap,
    WithoutPoles,
};

use super::Refusal;
use super::fit::{check_exactness, check_first_order, check_tensor};
use super::lattice::SceneLattice;
use super::part_choice::PartChoice;
use super::parts::{Base, Parts};
use super::request::formula_refusal;
use super::stepping::{LatticeBase, LatticeStepping, MapStepping, Stepping};
use crate::document::{PartSpec, SceneDocument};

/// Checks the parts of libraries and of the scene's own formulas on the system. A realization is checked by its tensor.
/// The map of the parts is checked by its first order, on a long lattice the map of its short one.
pub(super) fn check_own_parts(
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
pub(super) fn compose_written(
    system: &PoissonSystem,
    parts: Parts,
) -> Result<Stepping, BuildError> {
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
pub(super) fn compose_lattice(
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
        numbers: own.numbers()?,
        stepped: WithoutPoles::of_lattice(lattice, map)?,
        is_composed,
        base,
    })
}

/// Parts that do not fit each other or the system.
pub(super) fn method_refusal(
    document: &SceneDocument,
    registry: &Registry,
    error: &BuildError,
) -> Refusal {
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
