//! A scene's families as a lattice of any length.

use leafwise_core::lattice::observables::SiteDensity;
use leafwise_core::lattice::{LatticeGeometry, LatticeSource};
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::syntax::Formula;

use super::Refusal;
use super::definitions::scope;
use super::dense::DENSE_LIMIT;
use super::instantiate::{geometry, instantiate};
use super::names::{parse, refusal};
use super::observables::{Observable, coordinate};
use super::time::wants_time;
use crate::document::{BracketSpec, Located, SceneDocument};

/// A scene whose families are too long to be written out.
pub(super) struct SceneLattice<'a> {
    document: &'a SceneDocument,
    geometry: LatticeGeometry,
}

/// The largest dimension of a lattice that is written out for a stepper without sweeps.
pub(super) const STEPPER_LIMIT: usize = 1024;

/// The numbers a coordinate that a run keeps for a method of so many fields, at its first checkpoint: the states
/// of the run and of the file, and of each field what the next step begins with. Two million coordinates take
/// 19 at 2 fields, and 42 at 8, and by `hamilton-jacobi`, which keeps what following a branch needs, 41 at 4.
fn numbers_a_coordinate(fields: usize) -> usize {
    29 + 3 * fields
}

/// A lattice that every formula of a scene is tried on before anything is built.
const TRIAL_LENGTH: usize = 9;

impl<'a> SceneLattice<'a> {
    /// The lattice of a scene with more than [`DENSE_LIMIT`] coordinates in families, `None` for
    /// one that is written out.
    ///
    /// # Errors
    /// A scene that has single variables beside such families, or the time as a coordinate.
    pub fn of(document: &'a SceneDocument) -> Result<Option<Self>, Refusal> {
        let system = &document.system;
        if system.families.is_empty() || system.coordinates() <= DENSE_LIMIT {
            return Ok(None);
        }
        if let Some((formula, what)) = wants_time(document) {
            return Err(Box::new(document.diagnostic(
                &document.place_in_formula(formula, 0..formula.value.len()),
                format!(
                    "{what} is not offered on a lattice of more than {DENSE_LIMIT} coordinates, and this one has {}: \
                     every site moves t's energy",
                    system.coordinates()
                ),
                "here",
                Some("shorten the lattice".to_owned()),
            )));
        }
        if let Some(single) = system.variables.first() {
            return Err(Box::new(document.diagnostic(
                &single.place(),
                format!(
                    "a lattice of more than {DENSE_LIMIT} coordinates has no single variables \
                     beside its families"
                ),
                "this variable",
                Some("make it a family, or shorten the lattice".to_owned()),
            )));
        }
        if has_forms(&system.bracket.value, &system.constraints) {
            return Err(Box::new(document.diagnostic(
                &system.bracket.place(),
                format!(
                    "a lattice of more than {DENSE_LIMIT} coordinates has its bracket by entries, not by a form \
                     or with constraints, whose inverse couples all sites"
                ),
                "this bracket",
                Some("write its entries, or shorten the lattice".to_owned()),
            )));
        }
        if let Some(place) = system.forces.place() {
            return Err(Box::new(document.diagnostic(
                &place,
                format!("forces are not offered on a lattice of more than {DENSE_LIMIT} coordinates, and this one has {}", system.coordinates()),
                "here",
                Some("shorten the lattice".to_owned()),
            )));
        }
        let geometry = geometry(document);
        has_room(document, geometry.dimension(), 1)?;
        Ok(Some(Self { document, geometry }))
    }

    /// The number of coordinates.
    pub fn dimension(&self) -> usize {
        self.geometry.dimension()
    }

    /// The system on a short lattice with what the run records, errors underlined in the scene.
    pub fn trial(&self) -> Result<(PoissonSystem, LatticeGeometry, Vec<Observable>), Refusal> {
        let geometry = self
            .geometry
            .resized(TRIAL_LENGTH.min(self.geometry.length()));
        let mut written = instantiate(self.document, &lengths(&geometry))?;
        let observables = std::mem::take(&mut written.observables);
        let bracket = &self.document.system.bracket;
        let system = written.system(self.document).map_err(|error| {
            self.document
                .diagnostic(&bracket.place(), error.to_string(), "here", None)
        })?;
        let scope = scope(self.document, &lengths(&geometry), None)?;
        for formula in self.formulas() {
            parse(self.document, formula)?
                .density(&scope, geometry.length() / 2)
                .map_err(|error| refusal(self.document, formula, &error))?;
        }
        Ok((system, geometry, observables))
    }

    /// What the run watches: the energy, the Casimirs, then formulas of the state.
    fn formulas(&self) -> Vec<&'a Located<String>> {
        let system = &self.document.system;
        let named = |name: &str| {
            name == "energy"
                || system
                    .casimirs
                    .iter()
                    .any(|(casimir, _)| casimir.value == name)
        };
        let recorded = self.document.run.record.observables.iter();
        let recorded = recorded
            .map(|observable| &observable.formula)
            .filter(|formula| {
                let text = &formula.value;
                !named(text) && coordinate(&self.geometry, text).is_none()
            });
        std::iter::once(&system.hamiltonian)
            .chain(system.casimirs.iter().map(|(_, formula)| formula))
            .chain(recorded)
            .collect()
    }
}

/// Asks for the memory of a run at once, so that too long a lattice is an error here and not the end of
/// the program in the middle of it. Before a method is built, it has one field at least.
pub(super) fn has_room(
    document: &SceneDocument,
    coordinates: usize,
    fields: usize,
) -> Result<(), Refusal> {
    let numbers = coordinates.saturating_mul(numbers_a_coordinate(fields));
    let mut room: Vec<f64> = Vec::new();
    let Err(_) = room.try_reserve_exact(numbers) else {
        return Ok(());
    };
    let gigabytes = numbers as f64 * size_of::<f64>() as f64 / 1e9;
    let first = document.system.families.first();
    let place = first.map_or_else(|| document.system.bracket.place(), |(name, _)| name.place());
    Err(Box::new(document.diagnostic(
        &place,
        format!(
            "a lattice of {coordinates} coordinates takes {gigabytes:.1} gigabytes of memory, more than \
             there is"
        ),
        "here",
        Some("shorten the lattice".to_owned()),
    )))
}

/// Whether a bracket, or a summand of it, is made of a form or with constraints.
pub(super) fn has_forms(bracket: &BracketSpec, constraints: &[Located<String>]) -> bool {
    let is_formed = match bracket {
        BracketSpec::OneForm(_) | BracketSpec::TwoForm(_) => true,
        BracketSpec::Sum(summands) => summands
            .iter()
            .any(|summand| has_forms(&summand.bracket.value, &summand.constraints)),
        _ => false,
    };
    is_formed || !constraints.is_empty()
}

/// The lengths of a lattice's families.
fn lengths(geometry: &LatticeGeometry) -> Vec<usize> {
    geometry.families.iter().map(|family| family.1).collect()
}

/// A state of a shorter lattice that looks like `state` at both ends.
pub(super) fn shortened(
    state: &[f64],
    geometry: &LatticeGeometry,
    shorter: &LatticeGeometry,
) -> Vec<f64> {
    let mut short = Vec::with_capacity(shorter.dimension());
    let families = shorter
        .families
        .iter()
        .zip(&geometry.families)
        .zip(geometry.offsets());
    for (((_, length), (_, full)), offset) in families {
        for site in 0..*length {
            let like = if site <= length / 2 {
                site
            } else {
                full - (length - site)
            };
            short.push(state[offset + like]);
        }
    }
    short
}

impl LatticeSource for SceneLattice<'_> {
    fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    fn write_out(&self, geometry: &LatticeGeometry) -> Result<PoissonSystem, BuildError> {
        instantiate(self.document, &lengths(geometry))
            .map_err(|refusal| BuildError::Lattice {
                message: refusal.message.clone(),
            })?
            .system(self.document)
    }

    fn densities(
        &self,
        geometry: &LatticeGeometry,
        site: usize,
    ) -> Result<Vec<SiteDensity>, BuildError> {
        let scope = scope(self.document, &lengths(geometry), None).map_err(|refusal| {
            BuildError::Lattice {
                message: refusal.message.clone(),
            }
        })?;
        self.formulas()
            .into_iter()
            .map(|formula| {
                let density = Formula::parse(&formula.value)
                    .and_then(|parsed| parsed.density(&scope, site))
                    .map_err(|error| BuildError::Lattice {
                        message: error.to_string(),
                    })?;
                Ok(SiteDensity {
                    constant: density.constant,
                    site: density.site,
                })
            })
            .collect()
    }
}
