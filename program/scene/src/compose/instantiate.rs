//! Templates over families, written out at chosen lengths.

use leafwise_core::Convention;
use leafwise_core::lattice::{Axis, LatticeGeometry};
use leafwise_core::system::{Casimir, Forces, Metric, Parameter};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::Expression;

use super::Refusal;
use super::channels::{Channel, channels};
use super::definitions::scope;
use super::events::{Events, events};
use super::extended::Extension;
use super::forces::forces;
use super::forms::{Forms, forms};
use super::names::{coordinate_names, function};
use super::observables::{Observable, observables};
use super::tensor::{Entries, entries};
use crate::document::{self, Boundary, SceneDocument};

/// A scene's system with every site written out.
#[derive(Clone, Debug)]
pub struct Instantiated {
    /// The coordinates: single variables, then `x[0]`, `x[1]`, … of each family.
    pub names: Vec<String>,
    /// {x_i, x_j} for i < j, as the scene's author wrote them.
    pub bracket: Entries,
    /// Forms that make the tensor in place of entries, and the constraints on it.
    pub forms: Forms,
    /// H.
    pub hamiltonian: Expression,
    /// Forces that move the system beside H.
    pub forces: Forces,
    /// Channels of noise, which move the system at random.
    pub noise: Vec<Channel>,
    /// The Casimirs by name.
    pub casimirs: Vec<Casimir>,
    /// Observables that the run records.
    pub observables: Vec<Observable>,
    /// Events that the run watches between its steps.
    pub events: Events,
    /// The time and its energy behind the scene's own coordinates, where H names the time.
    pub extension: Option<Extension>,
}

/// Writes the scene's templates out with its families as long as those of `lattice`.
/// Inside formulas, `N` stays the scene's own length. A short lattice thus stands for a long one.
///
/// # Errors
/// The first formula that cannot be read, underlined in the scene. Families of unequal lengths on a periodic boundary.
pub fn instantiate(
    document: &SceneDocument,
    lattice: &LatticeGeometry,
) -> Result<Instantiated, Refusal> {
    check_lengths(document)?;
    let own = scope(document, lattice, None)?;
    let mut scope = own.clone();
    let mut extension = Extension::of(document, lattice, &mut scope)?;
    let mut names = coordinate_names(document, lattice);
    let system = &document.system;
    let mut hamiltonian = function(document, &scope, &system.hamiltonian)?;
    let casimirs = system
        .casimirs
        .iter()
        .map(|(name, formula)| {
            let expression = function(document, &own, formula)?;
            Ok(Casimir {
                name: name.value.clone(),
                expression,
            })
        })
        .collect::<Result<_, Refusal>>()?;
    let mut bracket = entries(document, &own, &names, lattice)?;
    let mut forms = forms(document, [&own, &scope], &names, lattice)?;
    let whole = geometry(document);
    let is_shortened = whole != *lattice;
    let of_whole = match is_shortened {
        true => Some(self::scope(document, &whole, None)?),
        false => None,
    };
    let of_whole = of_whole.as_ref().map(|names| (&whole, names));
    let observables = observables(document, &scope, of_whole)?;
    // Events name sites of the whole lattice.
    let events = match is_shortened {
        true => Events::default(),
        false => events(document, &scope)?,
    };
    if let Some(extension) = &mut extension {
        let convention = system.convention;
        extension.extend(convention, &mut names, &mut bracket, &mut hamiltonian);
        forms.extend(extension);
    }
    let moving = moving(document, lattice);
    let longest = lattice.length().max(1);
    let forces = forces(document, &scope, &names[..moving], (names.len(), longest))?;
    let noise = channels(document, &scope, longest)?;
    Ok(Instantiated {
        names,
        bracket,
        forms,
        hamiltonian,
        forces,
        noise,
        casimirs,
        observables,
        events,
        extension,
    })
}

/// The number of coordinates that move, with the families as long as those of `lattice`.
pub(super) fn moving(document: &SceneDocument, lattice: &LatticeGeometry) -> usize {
    let system = &document.system;
    let families = lattice.families[..system.moving().len()].iter();
    system.variables.len() + families.map(|family| family.1).sum::<usize>()
}

/// The families of a scene at their true lengths.
pub(super) fn geometry(document: &SceneDocument) -> LatticeGeometry {
    let system = &document.system;
    let periodic = |axis: usize| system.boundary_along(axis) != Boundary::Open;
    let families = system.families.iter();
    match system.axes[..] {
        [] => {
            let families = families.map(|(name, length)| (name.value.clone(), length.value));
            LatticeGeometry::chain(families.collect(), periodic(0))
        }
        _ => {
            let axes = system.axes.iter().enumerate();
            let axes = axes.map(|(axis, length)| Axis {
                length: *length,
                periodic: periodic(axis),
            });
            let names = families.map(|(name, _)| name.value.clone());
            LatticeGeometry::along(names, axes.collect())
        }
    }
}

/// On a ring every family has the same length: a site index counts all of them.
fn check_lengths(document: &SceneDocument) -> Result<(), Refusal> {
    let system = &document.system;
    let is_open = system.boundary_along(0) == Boundary::Open;
    let Some(((first, length), rest)) = system.families.split_first() else {
        return Ok(());
    };
    let Some((other, differs)) = rest.iter().find(|(_, l)| l.value != length.value) else {
        return Ok(());
    };
    if is_open {
        return Ok(());
    }
    Err(Box::new(document.diagnostic(
        &differs.place(),
        format!(
            "on a periodic boundary all families have one length, and `{}` has {} sites where \
             `{}` has {}",
            other.value, differs.value, first.value, length.value
        ),
        "another length",
        Some("make them equal, or set boundary = \"open\"".to_owned()),
    )))
}

impl Instantiated {
    /// Adds coordinates that stay as they are, and feel no force.
    pub(super) fn rest(&mut self, names: impl IntoIterator<Item = String>) {
        self.names.extend(names);
        let count = self.names.len();
        if !self.forces.one_form.is_empty() {
            self.forces.one_form.resize(count, 0.into());
        }
        if let Some(damping) = &mut self.forces.damping
            && let Metric::Diagonal(entries) = &mut damping.metric
        {
            entries.resize(count, 0.into());
        }
    }

    /// The Poisson system of the scene's parameters and convention, [forms](Forms::apply) not yet applied.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] when a formula uses an index out of range.
    pub fn system(self, document: &SceneDocument) -> Result<PoissonSystem, BuildError> {
        let parameters = document
            .system
            .parameters
            .iter()
            .map(|(name, value)| Parameter {
                name: name.value.clone(),
                value: value.value.value,
            })
            .collect();
        let convention = match document.system.convention {
            document::Convention::HamiltonFirst => Convention::HamiltonianFirst,
            document::Convention::HamiltonSecond => Convention::HamiltonianSecond,
        };
        let system = SystemFormulas::new(
            self.names,
            parameters,
            self.bracket,
            self.hamiltonian,
            self.casimirs,
            convention,
        )?;
        Ok(system.with_forces(self.forces)?.into())
    }
}
