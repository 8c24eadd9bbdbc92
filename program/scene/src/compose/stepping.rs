//! The integrator of a scene: parts written out, a map of its own, or templates over a lattice.

use std::sync::Arc;

use leafwise_core::LatticeMethod;
use leafwise_core::lattice::{LatticeGeometry, LatticeMap, Swept};
use leafwise_core::noise::NoisyMap;
use leafwise_core::{Method, MotionClass, PoissonSystem, StepMap, Structure};

use super::channels::RunNoise;
use super::lattice_functions::LatticeFunctions;

/// How a scene's steps are taken.
#[derive(Clone)]
pub enum Stepping {
    /// Realization and dynamics, every coordinate with code of its own.
    Written(Box<Method>),
    /// A composition, or a stepper that stands in place of realization and dynamics.
    Map(MapStepping),
    /// One template a class of sites; the solver is the linear iteration.
    Lattice(Box<LatticeStepping>),
}

/// A step map that is not a method by itself.
#[derive(Clone)]
pub struct MapStepping {
    /// The map that is stepped.
    pub map: Arc<dyn StepMap>,
    /// The method it is made of, if it is one.
    pub method: Option<Box<Method>>,
    /// Whether it is a composition.
    pub is_composed: bool,
    /// Noise that its steps draw; the method then takes the increments as parameters behind the system's.
    pub noise: Option<(RunNoise, NoisyMap)>,
}

/// Map that sweeps over a lattice: realization and dynamics, or a stepper.
#[derive(Clone)]
pub enum LatticeBase {
    /// Realization and dynamics.
    Method(Box<LatticeMethod>),
    /// A stepper in their place.
    Sweeps(Box<LatticeMap>),
}

impl LatticeBase {
    /// The map.
    pub fn map(&self) -> &LatticeMap {
        match self {
            Self::Method(method) => method.map(),
            Self::Sweeps(map) => map,
        }
    }

    /// Realization and dynamics, unless a stepper stands in their place.
    pub fn method(&self) -> Option<&LatticeMethod> {
        match self {
            Self::Method(method) => Some(method),
            Self::Sweeps(_) => None,
        }
    }

    /// The map, to be composed.
    pub(super) fn shared(&self) -> Arc<dyn StepMap> {
        Arc::clone(&self.map().map)
    }
}

/// A lattice's map and its observers.
#[derive(Clone)]
pub struct LatticeStepping {
    /// Base of the steps: the map that is stepped, or composed.
    pub base: LatticeBase,
    /// Map that is stepped: the base or a composition of it, with poles not crossed.
    pub stepped: Arc<dyn StepMap>,
    /// The lattice.
    pub geometry: LatticeGeometry,
    /// The short lattice that is written out for it.
    pub written: LatticeGeometry,
    /// Noise that its steps draw.
    pub noise: Option<(RunNoise, NoisyMap)>,
    /// Whether it is a composition.
    pub is_composed: bool,
    /// A site of the lattice that is written out for it which moves as all sites do that are away from open ends; `None`
    /// where no site is.
    pub interior: Option<usize>,
    /// Energy and Casimirs.
    pub invariants: LatticeFunctions,
    /// Formulas of the state that the scene records.
    pub formulas: LatticeFunctions,
    /// The lattice as a system of numbers, where indicators of chaos need directions in its leaves.
    pub numbers: Option<PoissonSystem>,
}

impl LatticeStepping {
    /// The map that is stepped as a product of sweeps, where it is one: the base itself.
    pub(super) fn swept(&self) -> Option<Swept> {
        let LatticeBase::Sweeps(map) = &self.base else {
            return None;
        };
        let is_base = std::ptr::addr_eq(Arc::as_ptr(&map.map), Arc::as_ptr(&self.stepped));
        map.swept.clone().filter(|_| is_base)
    }
}

impl Stepping {
    /// The step map.
    pub fn map(&self) -> &dyn StepMap {
        match self {
            Self::Written(method) => method.as_ref(),
            Self::Map(stepping) => stepping.map.as_ref(),
            Self::Lattice(lattice) => lattice.stepped.as_ref(),
        }
    }

    /// The method of realization and dynamics that is written out, composed or not; with noise there is none whose parameters
    /// are the system's.
    pub fn written(&self) -> Option<&Method> {
        self.method().filter(|_| self.noise().is_none())
    }

    /// The same, with noise too.
    fn method(&self) -> Option<&Method> {
        match self {
            Self::Written(method) => Some(method),
            Self::Map(stepping) => stepping.method.as_deref(),
            Self::Lattice(_) => None,
        }
    }

    /// Noise that its steps draw, if they do.
    pub fn noise(&self) -> Option<&RunNoise> {
        self.drawn().map(|(noise, _)| noise)
    }

    /// The steps that draw, to be given other numbers.
    pub fn noisy(&self) -> Option<&NoisyMap> {
        self.drawn().map(|(_, map)| map)
    }

    fn drawn(&self) -> Option<&(RunNoise, NoisyMap)> {
        match self {
            Self::Map(stepping) => stepping.noise.as_ref(),
            Self::Lattice(lattice) => lattice.noise.as_ref(),
            Self::Written(_) => None,
        }
    }

    /// The declared order in t = εh, a lower bound.
    pub fn declared_order(&self) -> usize {
        self.map().properties().order
    }

    /// Parts that the steps are made of, as labels and descriptions, and how they follow a motion.
    pub fn parts(&self, motion: MotionClass) -> Vec<(&'static str, String)> {
        let mut lines = match (self, self.method()) {
            (_, Some(method)) => vec![
                ("Realization", method.realization().describe()),
                ("Dynamics", method.dynamics().describe()),
            ],
            (Self::Lattice(lattice), _) => match &lattice.base {
                LatticeBase::Method(method) => vec![
                    ("Realization", method.realization().describe()),
                    ("Dynamics", method.dynamics().describe()),
                ],
                LatticeBase::Sweeps(map) => vec![("Stepper", map.map.describe())],
            },
            _ => vec![("Stepper", self.map().describe())],
        };
        let is_composed = match self {
            Self::Map(stepping) => stepping.is_composed && stepping.method.is_some(),
            Self::Lattice(lattice) => lattice.is_composed,
            Self::Written(_) => false,
        };
        if is_composed {
            lines.push(("Composition", self.map().describe()));
        }
        if let Some(noise) = self.noise() {
            lines.push(("Noise", noise.describe()));
        }
        let properties = self.map().properties();
        lines.push((
            "Structure",
            match properties.structure {
                Structure::Exact => "a Poisson map, to round-off".to_owned(),
                Structure::Order(n) => format!("a Poisson map up to order {n}"),
                Structure::Leaves => {
                    "along symplectic leaves, Casimirs to round-off; not a Poisson map".to_owned()
                }
                Structure::Contact => {
                    "a contact map, to round-off: ds - p dq is multiplied by a function".to_owned()
                }
                Structure::None if motion == MotionClass::OffLeaves => {
                    "no Poisson map, as the motion is none: friction changes the tensor, and Casimirs where there are any"
                        .to_owned()
                }
                Structure::None => "not a Poisson map".to_owned(),
            },
        ));
        lines
    }

    /// The lattice, if it is one.
    pub fn lattice(&self) -> Option<&LatticeGeometry> {
        match self {
            Self::Written(_) | Self::Map(_) => None,
            Self::Lattice(lattice) => Some(&lattice.geometry),
        }
    }

    /// How the parts meet in a step.
    pub fn path(&self) -> String {
        match (self, self.method()) {
            (_, Some(method)) => method.path(),
            (Self::Lattice(_), _) => "sweeps over a lattice".to_owned(),
            _ => "a step map of its own".to_owned(),
        }
    }

    /// Costs of one iteration of the solver, as labels and counts.
    pub fn costs(&self) -> Vec<(&'static str, String)> {
        if let Some(method) = self.method() {
            return match method.newton() {
                None => vec![("Path", method.path())],
                Some(newton) => vec![
                    ("One Newton iteration", newton.operations().to_string()),
                    ("Residual alone", newton.residual_operations().to_string()),
                    (
                        "Coefficients, once",
                        newton.coefficient_operations().to_string(),
                    ),
                ],
            };
        }
        let Self::Lattice(lattice) = self else {
            return Vec::new();
        };
        let map = lattice.base.map();
        let sites = lattice.geometry.length();
        let each = match lattice.base {
            LatticeBase::Method(_) => "One iteration",
            LatticeBase::Sweeps(_) => "One evaluation",
        };
        vec![
            (
                each,
                format!(
                    "{} operations, {:.1} a site",
                    map.operations,
                    map.operations as f64 / sites as f64
                ),
            ),
            ("Fields", format!("{} numbers a coordinate", map.fields)),
        ]
    }
}
