//! What a survey measures: every pair of realization and dynamics, stepper and composition.

use std::fmt;
use std::sync::Arc;

use leafwise_core::part::{PartInfo, PartKind};
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
    /// A composition of Hamilton–Jacobi of order 2 over an exact realization that fits, or of splitting
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
            let parts = registry.parts().into_iter().filter(|p| p.kind == kind);
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

    /// The step map for a problem's system.
    ///
    /// # Errors
    /// [`BuildError`] where the parts do not fit; those of a library are looked at: a realization of
    /// another tensor, and formulas of another motion, are no broken declarations.
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
                        let splitting = registry.stepper("splitting")?;
                        let splitting = splitting.build(system, &PartParameters::new())?;
                        composition.build(splitting, &part.parameters)
                    }
                    built => built,
                }
            }
        }
    }
}

/// What a part is tried with: its defaults, or several orders and every choice it offers.
fn settings(part: &PartInfo, full: bool) -> Vec<Chosen> {
    let name = part.name;
    let takes = |key: &str| {
        part.parameters
            .iter()
            .any(|parameter| parameter.name == key)
    };
    let numbers = |key: &str, values: &[i64]| -> Vec<PartParameters> {
        let with = |value: &i64| PartParameters::new().with(key, *value);
        values.iter().map(with).collect()
    };
    let words = |key: &str, values: &[&str]| -> Vec<PartParameters> {
        let with = |value: &&str| PartParameters::new().with(key, *value);
        values.iter().map(with).collect()
    };
    let chosen = match name {
        // An adaptive method shows its order where the tolerance leaves the step alone.
        _ if takes("tolerance") => vec![PartParameters::new().with("tolerance", 0.1)],
        _ if !full => vec![PartParameters::new()],
        "karasev-truncated" => numbers("order", &[1, 2, 3, 4, 6, 8]),
        "karasev-collocated" => numbers("points", &[0, 1, 2, 3]),
        "so3-group" => words("chart", &["cayley", "exponential"]),
        "hamilton-jacobi" => numbers("order", &[2, 4, 6, 8]),
        "collective" => collective(),
        "gauss" => numbers("stages", &[1, 2, 3, 4]),
        "energy-preserving" => numbers("order", &[2, 4]),
        "projection" => words("base", &["rk4", "gauss"]),
        _ => vec![PartParameters::new()],
    };
    let of = |parameters| Chosen { name, parameters };
    chosen.into_iter().map(of).collect()
}

/// Every integrator, corrected and as in the paper.
fn collective() -> Vec<PartParameters> {
    let gauss = |stages: i64| {
        PartParameters::new()
            .with("integrator", "gauss")
            .with("stages", stages)
    };
    let verlet = PartParameters::new().with("integrator", "stormer-verlet");
    ["bisection", "none"]
        .into_iter()
        .flat_map(|correction| {
            let integrators = [verlet.clone(), gauss(1), gauss(2), gauss(3)];
            integrators.map(|parameters| parameters.with("correction", correction))
        })
        .collect()
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

/// The realizations that a composition is measured over, the first that fits: exact ones, so that
/// the composition's own order is seen.
const BASES: [&str; 5] = [
    "constant",
    "log-canonical",
    "so3-exponential",
    "lie-poisson",
    "karasev-collocated",
];

/// What compositions are measured over: Hamilton–Jacobi of order 2 over an exact realization.
fn base(registry: &Registry, system: &PoissonSystem) -> Result<Arc<dyn StepMap>, BuildError> {
    let dynamics = Chosen {
        name: "hamilton-jacobi",
        parameters: PartParameters::new().with("order", 2),
    };
    let over = |name| pair(registry, system, &Chosen::defaults(name), &dynamics);
    let exact = BASES.into_iter().find_map(|name| over(name).ok());
    exact.map_or_else(|| over("karasev-truncated"), Ok)
}
