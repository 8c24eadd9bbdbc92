//! Templates over families, written out at chosen lengths.

use leafwise_core::Convention;
use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::system::{Casimir, Forces, Parameter};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::Expression;
use leafwise_walk::Clock;

use super::Refusal;
use super::channels::{Channel, channels};
use super::contact::{Contact, SCALE};
use super::definitions::scope;
use super::events::{Events, events};
use super::extended::Extension;
use super::forces::forces;
use super::forms::{Forms, forms};
use super::geometry::{check_lengths, geometry, moving};
use super::names::{coordinate_names, function};
use super::observables::{Observable, observables};
use super::tensor::{Entries, entries};
use crate::document::{self, SceneDocument};

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
    /// The scale of a contact form behind all other coordinates, where the bracket is one.
    pub contact: Option<Contact>,
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
    let clock = extension.as_ref().map(|extension| extension.clock);
    let scale = clock.map_or(names.len(), Clock::end);
    let named = (names.as_slice(), scale);
    let contact = Contact::of(document, named, &mut bracket, &mut hamiltonian)?;
    if let Some(extension) = &mut extension {
        let convention = system.convention;
        extension.extend(convention, &mut names, &mut bracket, &mut hamiltonian);
        forms.extend(extension);
    }
    names.extend(contact.as_ref().map(|_| SCALE.to_owned()));
    let moving = moving(document, lattice);
    let forces = forces(document, &scope, &names[..moving], names.len())?;
    let noise = channels(document, &scope)?;
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
        contact,
    })
}

impl Instantiated {
    /// Adds coordinates that stay as they are, and feel no force.
    pub(super) fn rest(&mut self, names: impl IntoIterator<Item = String>) {
        self.names.extend(names);
        self.forces = std::mem::take(&mut self.forces).with_resting(self.names.len());
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
