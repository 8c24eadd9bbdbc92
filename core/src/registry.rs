//! Parts found by name: an ordinary value, filled from what is linked into the program and from
//! what is loaded at run time.

use std::collections::BTreeMap;
use std::sync::Arc;

use thiserror::Error;

use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::lattice::{LatticeMap, LatticeSource};
use crate::origin::Origin;
use crate::part::{PartInfo, PartKind, PartParameters};
use crate::realization::RealizationData;
use crate::solver::StepMap;
use crate::system::PoissonSystem;

/// A Poisson system that can be built from parameters.
pub trait SystemPart: Send + Sync {
    /// What it declares.
    fn info(&self) -> &'static PartInfo;
    /// The system (M, π, H).
    ///
    /// # Errors
    /// [`BuildError`] when a parameter is out of range.
    fn build(&self, parameters: &PartParameters) -> Result<PoissonSystem, BuildError>;
    /// The text of a scene's `[system]` table, for a system given by formulas.
    fn fragment(&self) -> Option<&str> {
        None
    }
    /// Whether it can compute values without formulas.
    fn has_numbers(&self) -> bool {
        self.fragment().is_none()
    }
    /// Where the values of a loaded part come from, for manifests: `expressions` or `numbers`.
    fn path(&self, parameters: &PartParameters) -> Option<&'static str> {
        let _ = parameters;
        None
    }
}

/// A realization that can be built for a system.
pub trait RealizationPart: Send + Sync {
    /// What it declares.
    fn info(&self) -> &'static PartInfo;
    /// Realization data R̂_ε of the system's (M, επ).
    ///
    /// # Errors
    /// [`BuildError`] when a parameter is out of range or the tensor does not fit.
    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError>;
    /// Where the values of a loaded part come from, for manifests: `expressions` or `numbers`.
    fn path(&self, parameters: &PartParameters) -> Option<&'static str> {
        let _ = parameters;
        None
    }
}

/// A dynamic approximation that can be built from parameters.
pub trait DynamicsPart: Send + Sync {
    /// What it declares.
    fn info(&self) -> &'static PartInfo;
    /// The dynamic approximation, not yet bound to a system.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] when a parameter is out of range.
    fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError>;
    /// Where the values of a loaded part come from, for manifests: `expressions` or `numbers`.
    fn path(&self, parameters: &PartParameters) -> Option<&'static str> {
        let _ = parameters;
        None
    }
}

/// A step map that needs no realization.
pub trait StepperPart: Send + Sync {
    /// What it declares.
    fn info(&self) -> &'static PartInfo;
    /// The step map of a system.
    ///
    /// # Errors
    /// [`BuildError`] when a parameter is out of range or the system does not fit.
    fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError>;
    /// Where the values of a loaded part come from, for manifests: `expressions` or `numbers`.
    fn path(&self, parameters: &PartParameters) -> Option<&'static str> {
        let _ = parameters;
        None
    }
    /// The step map of a long lattice, as sweeps over its sites.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] where the part has no such form, for this lattice or for any;
    /// otherwise as [`build`](Self::build).
    fn build_on_lattice(
        &self,
        source: &dyn LatticeSource,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn LatticeMap>, BuildError> {
        let _ = (source, parameters);
        Err(BuildError::DoesNotFit {
            part: self.info().name,
            reason: "it has no form that sweeps over the sites of a long lattice".to_owned(),
        })
    }
}

/// A composition of step maps.
pub trait CompositionPart: Send + Sync {
    /// What it declares.
    fn info(&self) -> &'static PartInfo;
    /// The composition of `base`.
    ///
    /// # Errors
    /// [`BuildError::NotComposable`] when `base` lacks the symmetry the composition needs.
    fn build(
        &self,
        base: Arc<dyn StepMap>,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError>;
}

/// A part of any kind.
#[derive(Clone)]
pub enum Part {
    /// A system.
    System(Arc<dyn SystemPart>),
    /// A realization.
    Realization(Arc<dyn RealizationPart>),
    /// A dynamic approximation.
    Dynamics(Arc<dyn DynamicsPart>),
    /// A step map.
    Stepper(Arc<dyn StepperPart>),
    /// A composition.
    Composition(Arc<dyn CompositionPart>),
}

impl Part {
    /// What it declares.
    pub fn info(&self) -> &'static PartInfo {
        match self {
            Self::System(part) => part.info(),
            Self::Realization(part) => part.info(),
            Self::Dynamics(part) => part.info(),
            Self::Stepper(part) => part.info(),
            Self::Composition(part) => part.info(),
        }
    }

    /// What it is.
    pub fn kind(&self) -> PartKind {
        match self {
            Self::System(_) => PartKind::System,
            Self::Realization(_) => PartKind::Realization,
            Self::Dynamics(_) => PartKind::Dynamics,
            Self::Stepper(_) => PartKind::Stepper,
            Self::Composition(_) => PartKind::Composition,
        }
    }
}

/// A part of a crate that is linked into the program; see [`built_in!`](crate::built_in).
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Makes the part.
    pub make: fn() -> Part,
    /// The crate's name.
    pub package: &'static str,
    /// The crate's version.
    pub version: &'static str,
}

#[doc(hidden)]
pub use inventory;

inventory::collect!(BuiltIn);

/// Makes a part of this crate one of [`Registry::with_builtin`]:
/// `built_in!(Realization, expression)`, with the variant of [`Part`](crate::registry::Part) and the
/// value that implements its trait.
#[macro_export]
macro_rules! built_in {
    ($kind:ident, $part:expr) => {
        $crate::registry::inventory::submit! {
            $crate::registry::BuiltIn {
                make: || $crate::registry::Part::$kind(::std::sync::Arc::new($part)),
                package: env!("CARGO_PKG_NAME"),
                version: env!("CARGO_PKG_VERSION"),
            }
        }
    };
}

/// Why a part was not registered. The registry is unchanged.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// A name that is taken, by whatever kind of part.
    #[error(
        "the {kind} `{name}` from {offered} cannot be registered: a {taken} of this name is there \
         already, from {origin}; load one of them only, or rename one"
    )]
    Duplicate {
        /// The name of both.
        name: &'static str,
        /// The kind of the part offered.
        kind: &'static str,
        /// Where it comes from.
        offered: Box<Origin>,
        /// The kind of the part that has the name.
        taken: &'static str,
        /// Where that one comes from.
        origin: Box<Origin>,
    },
    /// A part that declares another kind than it is registered as.
    #[error("`{name}` from {offered} declares itself a {declared} and is offered as a {kind}")]
    Kind {
        /// Its name.
        name: &'static str,
        /// What it declares.
        declared: &'static str,
        /// What it is offered as.
        kind: &'static str,
        /// Where it comes from.
        offered: Box<Origin>,
    },
}

#[derive(Clone)]
struct Entry {
    part: Part,
    origin: Origin,
}

/// The parts a program knows, by name. A name stands for one part, whatever its kind.
#[derive(Clone, Default)]
pub struct Registry {
    entries: BTreeMap<&'static str, Entry>,
}

impl Registry {
    /// No part.
    pub fn empty() -> Self {
        Self::default()
    }

    /// Every part linked into this program. A crate that nothing names is not linked: depend on
    /// the `leafwise` facade, which names them all.
    ///
    /// # Panics
    /// When two linked crates submit the same name: a defect of the program itself.
    pub fn with_builtin() -> Self {
        let mut registry = Self::empty();
        for built_in in inventory::iter::<BuiltIn> {
            let origin = Origin::built_in(built_in.package, built_in.version);
            if let Err(defect) = registry.register((built_in.make)(), origin) {
                panic!("{defect}");
            }
        }
        registry
    }

    /// Adds a part.
    ///
    /// # Errors
    /// [`RegistryError::Duplicate`] when its name is taken, [`RegistryError::Kind`] when it declares
    /// another kind than it has; nothing is added then.
    pub fn register(&mut self, part: Part, origin: Origin) -> Result<(), RegistryError> {
        let (info, kind) = (part.info(), part.kind());
        if info.kind != kind {
            return Err(RegistryError::Kind {
                name: info.name,
                declared: info.kind.noun(),
                kind: kind.noun(),
                offered: Box::new(origin),
            });
        }
        if let Some(entry) = self.entries.get(info.name) {
            return Err(RegistryError::Duplicate {
                name: info.name,
                kind: kind.noun(),
                offered: Box::new(origin),
                taken: entry.part.kind().noun(),
                origin: Box::new(entry.origin.clone()),
            });
        }
        self.entries.insert(info.name, Entry { part, origin });
        Ok(())
    }

    /// What every part declares, sorted by kind and name.
    pub fn parts(&self) -> Vec<&'static PartInfo> {
        self.listing().into_iter().map(|(info, _)| info).collect()
    }

    /// What every part declares and where it comes from, sorted by kind and name.
    pub fn listing(&self) -> Vec<(&'static PartInfo, &Origin)> {
        let entries = self.entries.values();
        let mut listing: Vec<_> = entries.map(|e| (e.part.info(), &e.origin)).collect();
        listing.sort_by_key(|(info, _)| info.kind);
        listing
    }

    /// Where the part of this name comes from.
    pub fn origin(&self, name: &str) -> Option<&Origin> {
        self.entries.get(name).map(|entry| &entry.origin)
    }

    fn part(&self, name: &str) -> Option<&Part> {
        self.entries.get(name).map(|entry| &entry.part)
    }

    /// The system of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn system(&self, name: &str) -> Result<Arc<dyn SystemPart>, BuildError> {
        match self.part(name) {
            Some(Part::System(part)) => Ok(Arc::clone(part)),
            _ => Err(self.unknown(PartKind::System, name)),
        }
    }

    /// The realization of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn realization(&self, name: &str) -> Result<Arc<dyn RealizationPart>, BuildError> {
        match self.part(name) {
            Some(Part::Realization(part)) => Ok(Arc::clone(part)),
            _ => Err(self.unknown(PartKind::Realization, name)),
        }
    }

    /// The dynamic approximation of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn dynamics(&self, name: &str) -> Result<Arc<dyn DynamicsPart>, BuildError> {
        match self.part(name) {
            Some(Part::Dynamics(part)) => Ok(Arc::clone(part)),
            _ => Err(self.unknown(PartKind::Dynamics, name)),
        }
    }

    /// The stepper of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn stepper(&self, name: &str) -> Result<Arc<dyn StepperPart>, BuildError> {
        match self.part(name) {
            Some(Part::Stepper(part)) => Ok(Arc::clone(part)),
            _ => Err(self.unknown(PartKind::Stepper, name)),
        }
    }

    /// The composition of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn composition(&self, name: &str) -> Result<Arc<dyn CompositionPart>, BuildError> {
        match self.part(name) {
            Some(Part::Composition(part)) => Ok(Arc::clone(part)),
            _ => Err(self.unknown(PartKind::Composition, name)),
        }
    }

    fn unknown(&self, kind: PartKind, name: &str) -> BuildError {
        let alike = |info: &&'static PartInfo| strsim::jaro_winkler(name, info.name);
        let suggestion = self
            .parts()
            .into_iter()
            .filter(|info| info.kind == kind && alike(info) > 0.75)
            .max_by(|a, b| alike(a).total_cmp(&alike(b)))
            .map(|info| info.name.to_owned());
        BuildError::UnknownPart {
            kind: kind.noun(),
            name: name.to_owned(),
            suggestion,
        }
    }
}
