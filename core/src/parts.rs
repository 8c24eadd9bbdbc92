//! Parts as values: what a part declares, and the function that makes it.

use std::sync::Arc;

use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::lattice::{LatticeMap, LatticeSource};
use crate::part::{PartInfo, PartKind, PartParameters};
use crate::realization::RealizationData;
use crate::solver::{Pieces, StepMap};
use crate::system::PoissonSystem;

type MakeSystem = dyn Fn(&PartParameters) -> Result<PoissonSystem, BuildError> + Send + Sync;
type MakeRealization = dyn Fn(&PoissonSystem, &PartParameters) -> Result<Arc<dyn RealizationData>, BuildError>
    + Send
    + Sync;
type MakeDynamics =
    dyn Fn(&PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError> + Send + Sync;
type MakeStepper =
    dyn Fn(&PoissonSystem, &PartParameters) -> Result<Arc<dyn StepMap>, BuildError> + Send + Sync;
type MakeSweeps = fn(&dyn LatticeSource, &PartParameters) -> Result<LatticeMap, BuildError>;
type MakeComposition =
    dyn Fn(Arc<dyn StepMap>, &PartParameters) -> Result<Arc<dyn StepMap>, BuildError> + Send + Sync;

/// A Poisson system that can be built from parameters.
#[derive(Clone)]
pub struct SystemPart {
    /// Declaration of the system: name, promises, domain, parameters.
    pub info: &'static PartInfo,
    /// The text of a scene's `[system]` table, for a system given by formulas.
    pub fragment: Option<Arc<str>>,
    make: Arc<MakeSystem>,
}

impl SystemPart {
    /// A system that `make` makes.
    pub fn new(
        info: &'static PartInfo,
        make: impl Fn(&PartParameters) -> Result<PoissonSystem, BuildError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            info,
            fragment: None,
            make: Arc::new(make),
        }
    }

    /// The same, given by formulas too: the text of a scene's `[system]` table.
    pub fn with_fragment(mut self, fragment: impl Into<Arc<str>>) -> Self {
        self.fragment = Some(fragment.into());
        self
    }

    /// The system (M, π, H).
    ///
    /// # Errors
    /// [`BuildError`] when a parameter is out of range.
    pub fn build(&self, parameters: &PartParameters) -> Result<PoissonSystem, BuildError> {
        (self.make)(parameters)
    }

    /// Whether it can compute values without formulas.
    pub fn has_numbers(&self) -> bool {
        self.fragment.is_none() || self.info.paths.len() > 1
    }
}

/// A realization that can be built for a system.
#[derive(Clone)]
pub struct RealizationPart {
    /// Declaration of the realization: name, promises, domain, parameters.
    pub info: &'static PartInfo,
    make: Arc<MakeRealization>,
}

impl RealizationPart {
    /// A realization that `make` makes for a system.
    pub fn new(
        info: &'static PartInfo,
        make: impl Fn(&PoissonSystem, &PartParameters) -> Result<Arc<dyn RealizationData>, BuildError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            info,
            make: Arc::new(make),
        }
    }

    /// Realization data R̂_ε of the system's (M, επ).
    ///
    /// # Errors
    /// [`BuildError`] when a parameter is out of range or the tensor does not fit.
    pub fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn RealizationData>, BuildError> {
        (self.make)(system, parameters)
    }
}

/// A dynamic approximation that can be built from parameters.
#[derive(Clone)]
pub struct DynamicsPart {
    /// Declaration of the dynamic approximation: name, promises, domain, parameters.
    pub info: &'static PartInfo,
    make: Arc<MakeDynamics>,
}

impl DynamicsPart {
    /// A dynamic approximation that `make` makes.
    pub fn new(
        info: &'static PartInfo,
        make: impl Fn(&PartParameters) -> Result<Arc<dyn DynamicApproximation>, BuildError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            info,
            make: Arc::new(make),
        }
    }

    /// The dynamic approximation, not yet bound to a system.
    ///
    /// # Errors
    /// [`BuildError::Parameter`] when a parameter is out of range.
    pub fn build(
        &self,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn DynamicApproximation>, BuildError> {
        (self.make)(parameters)
    }
}

/// A step map that needs no realization.
#[derive(Clone)]
pub struct StepperPart {
    /// Declaration of the stepper: name, promises, domain, parameters.
    pub info: &'static PartInfo,
    make: Arc<MakeStepper>,
    sweeps: Option<MakeSweeps>,
}

impl StepperPart {
    /// A step map that `make` makes for a system.
    pub fn new(
        info: &'static PartInfo,
        make: impl Fn(&PoissonSystem, &PartParameters) -> Result<Arc<dyn StepMap>, BuildError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            info,
            make: Arc::new(make),
            sweeps: None,
        }
    }

    /// The same with a form that sweeps over the sites of a long lattice.
    pub fn with_sweeps(mut self, make: MakeSweeps) -> Self {
        self.sweeps = Some(make);
        self
    }

    /// Step map of a system.
    ///
    /// # Errors
    /// [`BuildError`] when a parameter is out of range or the system does not fit. A system with forces gives
    /// [`BuildError::Forces`] where the part takes none, one with a friction [`BuildError::Friction`].
    pub fn build(
        &self,
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        system.unless_beyond(self.info.takes, self.info.name)?;
        (self.make)(system, parameters)
    }

    /// Step map of a long lattice, as sweeps over its sites.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] where the part has no such form, for this lattice or for any. Further errors are
    /// those of [`build`](Self::build).
    pub fn build_on_lattice(
        &self,
        source: &dyn LatticeSource,
        parameters: &PartParameters,
    ) -> Result<LatticeMap, BuildError> {
        match self.sweeps {
            Some(make) => make(source, parameters),
            None => Err(BuildError::DoesNotFit {
                part: self.info.name,
                reason: "it has no form that sweeps over the sites of a long lattice".to_owned(),
            }),
        }
    }
}

/// A composition of step maps.
#[derive(Clone)]
pub struct CompositionPart {
    /// Declaration of the composition: name, promises, domain, parameters.
    pub info: &'static PartInfo,
    /// Its order over a base of order 2.
    pub order: usize,
    /// Where its base must come apart into a map of order 1 and its adjoint: what it asks of their pieces.
    pub factors: Option<Pieces>,
    make: Arc<MakeComposition>,
}

impl CompositionPart {
    /// A composition that `make` makes of a step map.
    pub fn new(
        info: &'static PartInfo,
        order: usize,
        factors: Option<Pieces>,
        make: impl Fn(Arc<dyn StepMap>, &PartParameters) -> Result<Arc<dyn StepMap>, BuildError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            info,
            order,
            factors,
            make: Arc::new(make),
        }
    }

    /// The composition of `base`.
    ///
    /// # Errors
    /// [`BuildError::NotComposable`] when `base` lacks the symmetry the composition needs.
    pub fn build(
        &self,
        base: Arc<dyn StepMap>,
        parameters: &PartParameters,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        (self.make)(base, parameters)
    }
}

/// A part of any kind.
#[derive(Clone)]
pub enum Part {
    /// A system.
    System(SystemPart),
    /// A realization.
    Realization(RealizationPart),
    /// A dynamic approximation.
    Dynamics(DynamicsPart),
    /// A step map.
    Stepper(StepperPart),
    /// A composition.
    Composition(CompositionPart),
}

macro_rules! kinds {
    ($($kind:ident: $part:ident),*) => {
        impl Part {
            /// Declaration of the part: name, promises, domain, parameters.
            pub fn info(&self) -> &'static PartInfo {
                match self {
                    $(Self::$kind(part) => part.info,)*
                }
            }

            /// Kind of the part, by its variant.
            pub fn kind(&self) -> PartKind {
                match self {
                    $(Self::$kind(_) => PartKind::$kind,)*
                }
            }
        }

        $(
            impl From<$part> for Part {
                fn from(part: $part) -> Self {
                    Self::$kind(part)
                }
            }
        )*
    };
}

kinds! {
    System: SystemPart,
    Realization: RealizationPart,
    Dynamics: DynamicsPart,
    Stepper: StepperPart,
    Composition: CompositionPart
}
