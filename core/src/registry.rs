//! Parts found by name: an ordinary value, filled from what is linked into the program.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::part::{PartInfo, PartKind, PartParameters};
use crate::realization::RealizationData;
use crate::solver::StepMap;
use crate::system::PoissonSystem;

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

/// A built-in part, submitted by its crate with `inventory::submit!`.
#[derive(Clone, Copy)]
pub enum BuiltIn {
    /// A realization.
    Realization(&'static dyn RealizationPart),
    /// A dynamic approximation.
    Dynamics(&'static dyn DynamicsPart),
    /// A step map.
    Stepper(&'static dyn StepperPart),
    /// A composition.
    Composition(&'static dyn CompositionPart),
}

inventory::collect!(BuiltIn);

/// The parts a program knows, by kind and name.
#[derive(Clone, Default)]
pub struct Registry {
    realizations: BTreeMap<&'static str, &'static dyn RealizationPart>,
    dynamics: BTreeMap<&'static str, &'static dyn DynamicsPart>,
    steppers: BTreeMap<&'static str, &'static dyn StepperPart>,
    compositions: BTreeMap<&'static str, &'static dyn CompositionPart>,
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
        for part in inventory::iter::<BuiltIn> {
            let fresh = match *part {
                BuiltIn::Realization(part) => registry
                    .realizations
                    .insert(part.info().name, part)
                    .is_none(),
                BuiltIn::Dynamics(part) => {
                    registry.dynamics.insert(part.info().name, part).is_none()
                }
                BuiltIn::Stepper(part) => {
                    registry.steppers.insert(part.info().name, part).is_none()
                }
                BuiltIn::Composition(part) => registry
                    .compositions
                    .insert(part.info().name, part)
                    .is_none(),
            };
            assert!(fresh, "two built-in parts share a name");
        }
        registry
    }

    /// What every part declares, by kind and name.
    pub fn parts(&self) -> Vec<&'static PartInfo> {
        self.realizations
            .values()
            .map(|p| p.info())
            .chain(self.dynamics.values().map(|p| p.info()))
            .chain(self.steppers.values().map(|p| p.info()))
            .chain(self.compositions.values().map(|p| p.info()))
            .collect()
    }

    /// The realization of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn realization(&self, name: &str) -> Result<&'static dyn RealizationPart, BuildError> {
        self.realizations
            .get(name)
            .copied()
            .ok_or_else(|| unknown(PartKind::Realization, name, self.realizations.keys()))
    }

    /// The dynamic approximation of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn dynamics(&self, name: &str) -> Result<&'static dyn DynamicsPart, BuildError> {
        self.dynamics
            .get(name)
            .copied()
            .ok_or_else(|| unknown(PartKind::Dynamics, name, self.dynamics.keys()))
    }

    /// The stepper of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn stepper(&self, name: &str) -> Result<&'static dyn StepperPart, BuildError> {
        self.steppers
            .get(name)
            .copied()
            .ok_or_else(|| unknown(PartKind::Stepper, name, self.steppers.keys()))
    }

    /// The composition of this name.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] with the nearest name.
    pub fn composition(&self, name: &str) -> Result<&'static dyn CompositionPart, BuildError> {
        self.compositions
            .get(name)
            .copied()
            .ok_or_else(|| unknown(PartKind::Composition, name, self.compositions.keys()))
    }
}

fn unknown<'a>(
    kind: PartKind,
    name: &str,
    known: impl Iterator<Item = &'a &'static str>,
) -> BuildError {
    let suggestion = known
        .map(|k| (strsim::jaro_winkler(name, k), *k))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, k)| k.to_owned());
    BuildError::UnknownPart {
        kind: kind.noun(),
        name: name.to_owned(),
        suggestion,
    }
}
