//! Parts found by name: an ordinary value, filled from what is linked into the program and from
//! what is loaded at run time.

use std::collections::BTreeMap;
use std::sync::Arc;

use thiserror::Error;

use crate::error::BuildError;
use crate::origin::Origin;
use crate::part::{Auto, Family, PartInfo, PartKind, PartParameters};

pub use crate::parts::{
    CompositionPart, DynamicsPart, Part, RealizationPart, StepperPart, SystemPart,
};

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
/// `built_in!(RealizationPart::new(&INFO, build))`.
#[macro_export]
macro_rules! built_in {
    ($part:expr) => {
        $crate::registry::inventory::submit! {
            $crate::registry::BuiltIn {
                make: || $crate::registry::Part::from($part),
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
        "the {kind} `{name}` from {offered} cannot be registered: a {taken} of this name is \
         already registered, from {origin}; load only one of them, or rename one"
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
        /// Kind that it declares.
        declared: &'static str,
        /// Kind that it is offered as.
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
    /// Arrays in the place of files, by the names of their tables.
    arrays: BTreeMap<String, Arc<NumberArray>>,
}

/// Numbers at the nodes of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberArray {
    /// How many nodes there are along each axis.
    pub shape: Vec<usize>,
    /// The numbers, the last axis fastest.
    pub numbers: Vec<f64>,
}

impl Registry {
    /// No part.
    pub fn empty() -> Self {
        Self::default()
    }

    /// Every part linked into this program. A crate that nothing names is not linked. Depend on the `leafwise` facade,
    /// which names them all.
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

    /// Adds the numbers of a table of scenes, in the place of a file.
    pub fn add_array(&mut self, name: impl Into<String>, array: NumberArray) {
        self.arrays.insert(name.into(), Arc::new(array));
    }

    /// The numbers of the table of this name, where they are given in the place of a file.
    pub fn array(&self, name: &str) -> Option<Arc<NumberArray>> {
        self.arrays.get(name).cloned()
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

    /// Declarations of all parts, sorted by kind and name.
    pub fn parts(&self) -> Vec<&'static PartInfo> {
        self.listing().into_iter().map(|(info, _)| info).collect()
    }

    /// Declarations of all parts with their origins, sorted by kind and name.
    pub fn listing(&self) -> Vec<(&'static PartInfo, &Origin)> {
        let entries = self.entries.values();
        let mut listing: Vec<_> = entries.map(|e| (e.part.info(), &e.origin)).collect();
        listing.sort_by_key(|(info, _)| info.kind);
        listing
    }

    /// The realization or the dynamic approximation that serves every system, to an order.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] where there is none.
    pub fn of_order(&self, kind: PartKind) -> Result<&'static PartInfo, BuildError> {
        let mut parts = self.parts().into_iter();
        parts
            .find(|info| info.kind == kind && info.is_of_order())
            .ok_or_else(|| self.unknown(kind, "auto"))
    }

    /// The dynamic approximation that serves every system with forces.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] where there is none.
    pub fn of_forces(&self) -> Result<&'static PartInfo, BuildError> {
        let mut parts = self.parts().into_iter();
        parts
            .find(|info| info.kind == PartKind::Dynamics && info.auto == Some(Auto::Forces))
            .ok_or_else(|| self.unknown(PartKind::Dynamics, "auto"))
    }

    /// The parts of a kind that comparisons try, the first ones first.
    pub fn compared(&self, kind: PartKind) -> Vec<&'static PartInfo> {
        let rank = |info: &&PartInfo| info.compared.map(|compared| compared.rank);
        let mut parts = self.parts();
        parts.retain(|info| info.kind == kind && info.compared.is_some());
        parts.sort_by_key(rank);
        parts
    }

    /// The steppers of a family that comparisons try, the first ones first.
    pub fn family(&self, family: Family) -> Vec<&'static PartInfo> {
        let mut parts = self.compared(PartKind::Stepper);
        parts.retain(|info| info.family == Some(family));
        parts
    }

    /// The stepper of a family that errors are measured against, with its settings.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] where there is none.
    pub fn reference(&self, family: Family) -> Result<(StepperPart, PartParameters), BuildError> {
        let found = self.family(family).into_iter().find_map(|info| {
            let settings = info.reference?;
            Some((info.name, PartParameters::of(settings)))
        });
        let (name, given) = found.ok_or_else(|| self.unknown(PartKind::Stepper, "reference"))?;
        Ok((self.stepper(name)?, given))
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
    pub fn system(&self, name: &str) -> Result<SystemPart, BuildError> {
        match self.part(name) {
            Some(Part::System(part)) => Ok(part.clone()),
            _ => Err(self.unknown(PartKind::System, name)),
        }
    }

    /// The realization of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn realization(&self, name: &str) -> Result<RealizationPart, BuildError> {
        match self.part(name) {
            Some(Part::Realization(part)) => Ok(part.clone()),
            _ => Err(self.unknown(PartKind::Realization, name)),
        }
    }

    /// The dynamic approximation of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn dynamics(&self, name: &str) -> Result<DynamicsPart, BuildError> {
        match self.part(name) {
            Some(Part::Dynamics(part)) => Ok(part.clone()),
            _ => Err(self.unknown(PartKind::Dynamics, name)),
        }
    }

    /// The stepper of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn stepper(&self, name: &str) -> Result<StepperPart, BuildError> {
        match self.part(name) {
            Some(Part::Stepper(part)) => Ok(part.clone()),
            _ => Err(self.unknown(PartKind::Stepper, name)),
        }
    }

    /// The composition of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn composition(&self, name: &str) -> Result<CompositionPart, BuildError> {
        match self.part(name) {
            Some(Part::Composition(part)) => Ok(part.clone()),
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
