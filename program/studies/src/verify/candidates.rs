//! Candidates of a survey: every pair of realization and dynamics, every stepper and composition.

use std::fmt;
use std::sync::Arc;

use leafwise_core::part::{Family, PartInfo, PartKind};
use leafwise_core::{BuildError, Method, Origin, PartParameters, PoissonSystem, Registry, StepMap};
use leafwise_scene::compose::{check_first_order, check_tensor};

use super::problem::Problem;

/// A part by name with the parameters it is tried with.
#[derive(Clone, Debug)]
pub struct Chosen {
    name: &'static str,
    parameters: PartParameters,
}

impl Chosen {
    fn defaults(name: &'static str) -> Self {
        Self {
            name,
            parameters: PartParameters::new(),
        }
    }
}

/// Refuses a map by a library's formulas alone that follows another motion: they do not say for which
/// system they are meant.
fn check_formulas(
    part: &'static PartInfo,
    problem: &Problem,
    map: &dyn StepMap,
) -> Result<(), BuildError> {
    if part.is_formulas_alone() {
        check_first_order(part.name, &problem.system, map, 1.0, &problem.initial)
    } else {
        Ok(())
    }
}

/// Whether a part comes from a library.
fn is_loaded(registry: &Registry, name: &str) -> bool {
    matches!(registry.origin(name), Some(Origin::Library { .. }))
}

/// A combination of parts, not yet built.
#[derive(Clone, Debug)]
pub enum Candidate {
    /// A realization and a dynamic approximation.
    Pair(Chosen, Chosen),
    /// A step map of its own.
    Stepper(Chosen),
    /// A composition of the dynamics of order 2, with forces or without, over an exact realization that fits, or of splitting
    /// where it takes factors.
    Composition(Chosen),
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pair(realization, dynamics) => {
                write!(f, "{} + {}", realization.name, dynamics.name)
            }
            Self::Stepper(part) | Self::Composition(part) => f.write_str(part.name),
        }
    }
}

impl Candidate {
    /// Every combination of the registry's parts, at their default orders or at several (`full`).
    pub fn all(registry: &Registry, full: bool) -> Vec<Self> {
        let of_kind = |kind: PartKind| -> Vec<Chosen> {
            let parts = registry.parts().into_iter();
            // Formulas are a scene's own, and tried as its method.
            let parts = parts.filter(|p| p.kind == kind && !p.is_written);
            parts.flat_map(|part| settings(part, full)).collect()
        };
        let dynamics = of_kind(PartKind::Dynamics);
        let pairs = of_kind(PartKind::Realization).into_iter().flat_map(|r| {
            let pair = move |d: &Chosen| Self::Pair(r.clone(), d.clone());
            dynamics.iter().map(pair).collect::<Vec<_>>()
        });
        let steppers = of_kind(PartKind::Stepper).into_iter().map(Self::Stepper);
        let compositions = of_kind(PartKind::Composition);
        pairs
            .chain(steppers)
            .chain(compositions.into_iter().map(Self::Composition))
            .collect()
    }

    /// Builds the step map for a problem's system.
    ///
    /// # Errors
    /// Returns [`BuildError`] where the parts do not fit. Parts of a library are checked too: a realization of another
    /// tensor and formulas of another motion are refused, and are no broken declarations.
    pub fn build(
        &self,
        registry: &Registry,
        problem: &Problem,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        let system = &problem.system;
        let map = self.map(registry, system)?;
        match self {
            Self::Pair(realization, dynamics) => {
                if is_loaded(registry, realization.name) {
                    let part = registry.realization(realization.name)?;
                    let built = part.build(system, &realization.parameters)?;
                    check_tensor(realization.name, system, &built, &problem.initial)?;
                }
                let part = registry.dynamics(dynamics.name)?;
                check_formulas(part.info, problem, map.as_ref())?;
            }
            Self::Stepper(stepper) => {
                let part = registry.stepper(stepper.name)?;
                check_formulas(part.info, problem, map.as_ref())?;
            }
            Self::Composition(_) => {}
        }
        Ok(map)
    }

    fn map(
        &self,
        registry: &Registry,
        system: &PoissonSystem,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        match self {
            Self::Pair(realization, dynamics) => pair(registry, system, realization, dynamics),
            Self::Stepper(part) => registry.stepper(part.name)?.build(system, &part.parameters),
            Self::Composition(part) => {
                let composition = registry.composition(part.name)?;
                match composition.build(base(registry, system)?, &part.parameters) {
                    Err(BuildError::NoFactors { .. }) => {
                        let (splitting, given) = registry.reference(Family::Splitting)?;
                        composition.build(splitting.build(system, &given)?, &part.parameters)
                    }
                    built => built,
                }
            }
        }
    }
}

/// Settings that a part is tried with: its defaults, or with `full` several orders and every choice it offers.
fn settings(part: &PartInfo, full: bool) -> Vec<Chosen> {
    let name = part.name;
    let takes = |key: &str| {
        part.parameters
            .iter()
            .any(|parameter| parameter.name == key)
    };
    let chosen = if takes("tolerance") {
        // An adaptive method shows its order where the tolerance leaves the step alone.
        vec![PartParameters::new().with("tolerance", 0.1)]
    } else if full && !part.surveyed.is_empty() {
        let settings = part.surveyed.iter();
        settings
            .map(|settings| PartParameters::of(settings))
            .collect()
    } else {
        vec![PartParameters::new()]
    };
    let of = |parameters| Chosen { name, parameters };
    chosen.into_iter().map(of).collect()
}

fn pair(
    registry: &Registry,
    system: &PoissonSystem,
    realization: &Chosen,
    dynamics: &Chosen,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let realization = registry
        .realization(realization.name)?
        .build(system, &realization.parameters)?;
    let dynamics = registry
        .dynamics(dynamics.name)?
        .build(&dynamics.parameters)?;
    Ok(Arc::new(Method::compose(system, realization, dynamics)?))
}

/// Base map over which compositions are measured: dynamics of order 2 over an exact realization.
fn base(registry: &Registry, system: &PoissonSystem) -> Result<Arc<dyn StepMap>, BuildError> {
    let dynamics = match system.has_forces() {
        true => Chosen::defaults(registry.of_forces()?.name),
        false => Chosen {
            name: registry.of_order(PartKind::Dynamics)?.name,
            parameters: PartParameters::new().with("order", 2),
        },
    };
    let over = |name| pair(registry, system, &Chosen::defaults(name), &dynamics);
    let mut exact = registry.exact_realizations().into_iter();
    match exact.find_map(|(info, _)| over(info.name).ok()) {
        Some(map) => Ok(map),
        None => over(registry.of_order(PartKind::Realization)?.name),
    }
}
