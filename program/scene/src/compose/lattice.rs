//! A scene's families as a lattice of any length.

use leafwise_core::lattice::observables::SiteDensity;
use leafwise_core::lattice::{
    LatticeGeometry, LatticeNumbers, LatticeObservables, LatticeSource, TemplateReach, proxy_of,
};
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{AXES, Formula};

use super::Refusal;
use super::definitions::scope;
use super::dense::{DENSE_LIMIT, WRITTEN_LIMIT};
use super::geometry::geometry;
use super::indicators::follows_tangents;
use super::instantiate::instantiate;
use super::lattice_functions::LatticeFunctions;
use super::lattice_noise::SiteTerms;
use super::names::{of_lattice, parse, refusal};
use super::observables::{Observable, asks_for_indicator, coordinate, observables, shadow_order};
use super::reach::reach;
use super::site_functions::SiteFunction;
use super::spin_temperature::SiteSpins;
use super::time::wants_time;
use crate::document::{BracketSpec, Located, SceneDocument};

/// A scene whose families are too long to be written out.
#[derive(Clone)]
pub(super) struct SceneLattice<'a> {
    document: &'a SceneDocument,
    /// Behind the scene's own families those of the increments of noise.
    geometry: LatticeGeometry,
    reach: TemplateReach,
    noise: Option<SiteTerms>,
    /// The spins of a site, where the run records their temperature.
    spins: Option<SiteSpins>,
}

/// Count of numbers per coordinate that a run keeps at its first checkpoint, for a method of so many fields. These are
/// the states of the run and of the file, and of each field the numbers with which the next step begins. Two million
/// coordinates take 19 at 2 fields, and 42 at 8. By `hamilton-jacobi`, which keeps the numbers that following a branch
/// needs, they take 41 at 4.
fn numbers_a_coordinate(fields: usize) -> usize {
    29 + 3 * fields
}

/// Count of numbers per coordinate that events between steps take. These are the state before the last step, shorter
/// steps from there, and each sum of a condition or a surface. Such a sum is written out term by term. A million
/// coordinates take 6 before a shorter step, and 130 for a sum over all.
fn numbers_of_events(document: &SceneDocument, fields: usize) -> usize {
    let run = &document.run;
    let section = run.section.as_ref().map(|section| &section.at);
    let texts: Vec<&str> = (run.stop.iter().chain(section))
        .map(|text| text.value.as_str())
        .collect();
    let sums: usize = texts.iter().map(|text| text.matches("sum").count()).sum();
    match texts.is_empty() {
        true => 0,
        false => 12 + 3 * fields + 130 * sums,
    }
}

/// The refusal of a name that is none, on a lattice of a few sites: formulas that name one are no templates for that alone.
fn unknown_name(document: &SceneDocument, geometry: &LatticeGeometry) -> Option<Refusal> {
    let lengths = geometry.lengths().into_iter();
    let lengths: Vec<usize> = lengths.map(|length| TRIAL_LENGTH.min(length)).collect();
    let refusal = instantiate(document, &geometry.resized(&lengths)).err()?;
    refusal.message.starts_with("unknown ").then_some(refusal)
}

/// Whether a scene asks for what no sweep over sites gives. Such are the time as a coordinate, displacements by the derivative
/// of a step, and a shadow energy. So are variables beside families, and brackets that are an inverse.
fn needs_all(document: &SceneDocument) -> bool {
    let system = &document.system;
    let mut recorded = document.run.record.observables.iter();
    let is_of_steps = |text: &str| asks_for_indicator(text) || shadow_order(text).is_some();
    wants_time(document).is_some()
        || recorded.any(|own| is_of_steps(&own.formula.value))
        || !system.variables.is_empty()
        || has_forms(&system.bracket.value, &system.constraints)
}

/// The shortest lattice that every formula of a scene is tried on before anything is built.
const TRIAL_LENGTH: usize = 9;

impl<'a> SceneLattice<'a> {
    /// Lattice of a scene with more than [`DENSE_LIMIT`] coordinates in families; `None` for one that is written out.
    /// Two kinds are written out. One has [`DENSE_LIMIT`] coordinates or fewer. The other has at most [`WRITTEN_LIMIT`], and a
    /// bracket, H or Casimir that couples sites at any distance, or what [needs all](needs_all) of them.
    ///
    /// # Errors
    /// Single variables beside such families, or the time as a coordinate. A formula that couples too many sites.
    pub fn of(document: &'a SceneDocument) -> Result<Option<Self>, Refusal> {
        let system = &document.system;
        let is_short = system.coordinates() <= DENSE_LIMIT
            || system.coordinates() <= WRITTEN_LIMIT && needs_all(document);
        if system.families.is_empty() || is_short {
            return Ok(None);
        }
        if let Some((formula, what)) = wants_time(document) {
            let is_pace = document.method.pace.as_ref() == Some(formula);
            let why = match is_pace {
                true => {
                    "the Hamiltonian is then (H + e) times it, under which every site is moved by the energy of all others"
                }
                false => "every site moves t's energy",
            };
            return Err(Box::new(document.diagnostic(
                &document.place_in_formula(formula, 0..formula.value.len()),
                format!(
                    "{what} is not offered on a lattice of more than {WRITTEN_LIMIT} coordinates, and this one has {}: {why}",
                    system.coordinates()
                ),
                "here",
                Some(format!("shorten the lattice, {}", system.shortening(WRITTEN_LIMIT))),
            )));
        }
        if let Some(single) = system.variables.first() {
            return Err(Box::new(document.diagnostic(
                &single.place(),
                format!(
                    "a lattice of more than {WRITTEN_LIMIT} coordinates has no single variables \
                     besides its families"
                ),
                "this variable",
                Some("make it a family, or shorten the lattice".to_owned()),
            )));
        }
        if has_forms(&system.bracket.value, &system.constraints) {
            return Err(Box::new(document.diagnostic(
                &system.bracket.place(),
                format!(
                    "a lattice of more than {WRITTEN_LIMIT} coordinates has its bracket by entries, not by a form \
                     or with constraints, whose inverse couples all sites"
                ),
                "this bracket",
                Some("write its entries, or shorten the lattice".to_owned()),
            )));
        }
        let geometry = geometry(document);
        has_room(document, geometry.dimension(), 1)?;
        let reach = match reach(document, TemplateReach::default()) {
            Ok(reach) => reach,
            Err(_) if system.coordinates() <= WRITTEN_LIMIT => return Ok(None),
            Err(refusal) => return Err(unknown_name(document, &geometry).unwrap_or(refusal)),
        };
        let mut lattice = Self {
            document,
            geometry,
            reach,
            noise: None,
            spins: None,
        };
        let is_long = lattice.dimension() > WRITTEN_LIMIT;
        let whole = scope(document, &lattice.geometry, None)?;
        for (formula, function) in lattice.recorded()? {
            if is_long {
                function.check_long(document, (formula, &whole))?;
            }
            for sum in function.sums() {
                let observed = lattice.reach.with_observable(sum);
                lattice.reach = observed.map_err(|error| refusal(document, formula, &error))?;
            }
            if matches!(function, SiteFunction::SpinTemperature) {
                let (written, _) =
                    proxy_of(&lattice, 1).map_err(|error| refused(document, &error))?;
                let system = lattice.write_out(&written);
                let system = system.map_err(|error| refused(document, &error))?;
                lattice.spins = Some(SiteSpins::of(&system, &written));
                // H's terms at a spin.
                let (terms, energy) = (lattice.reach.terms, lattice.reach.hamiltonian);
                lattice.reach.terms = std::array::from_fn(|axis| terms[axis].max(energy[axis]));
            }
        }
        Ok(Some(lattice))
    }

    /// The same moved by noise, whose increments are families at rest.
    pub fn with_noise(&self, noise: SiteTerms) -> Self {
        let mut with = self.clone();
        with.geometry.families = noise.extended(&self.geometry).families;
        with.noise = Some(noise);
        with
    }

    /// The same moved by other terms of its noise.
    pub fn with_flow(&self, noise: SiteTerms) -> Self {
        let noise = Some(noise);
        Self {
            noise,
            ..self.clone()
        }
    }

    /// The number of coordinates.
    pub fn dimension(&self) -> usize {
        self.geometry.dimension()
    }

    /// Whether it is moved by noise.
    pub fn has_noise(&self) -> bool {
        self.noise.is_some()
    }

    /// Whether it is written out for steppers that do not sweep: it is short enough, and not moved by noise at its sites.
    pub fn is_written_for_any(&self) -> bool {
        self.dimension() <= WRITTEN_LIMIT && !self.has_noise()
    }

    /// The lattice of the scene's own families at the lengths that `geometry` gives them.
    pub fn own(&self, geometry: &LatticeGeometry) -> LatticeGeometry {
        let mut own = geometry.clone();
        own.families.truncate(self.document.system.families.len());
        own
    }

    /// A site of a shorter lattice, or of the whole, that moves as all sites do that are away from open ends.
    pub fn interior(&self, written: &LatticeGeometry) -> Option<usize> {
        let (site, looks) = (written.middle(), self.reach.of_times(1, [true; AXES]));
        let (place, ends) = (written.place(site), written.ends());
        let shortest = written.families.iter().map(|family| family.1).min();
        let length = |axis: usize| match written.axes.len() {
            1 => shortest.unwrap_or(0),
            _ => written.axes[axis].length,
        };
        let is_inside = |axis: usize| {
            !ends[axis] || place[axis] >= looks[axis] && place[axis] + looks[axis] < length(axis)
        };
        (0..written.axes.len()).all(is_inside).then_some(site)
    }

    /// The system on a short lattice with what the run records, errors underlined in the scene.
    pub fn trial(&self) -> Result<(PoissonSystem, LatticeGeometry, Vec<Observable>), Refusal> {
        let document = self.document;
        let (mut geometry, _) = proxy_of(self, 1).map_err(|error| refused(document, &error))?;
        if geometry.length() < TRIAL_LENGTH {
            let lengths = self.geometry.lengths().into_iter();
            let lengths: Vec<usize> = lengths.map(|length| TRIAL_LENGTH.min(length)).collect();
            geometry = self.geometry.resized(&lengths);
        }
        instantiate(document, &self.own(&geometry))?;
        let system = self.write_out(&geometry);
        let system = system.map_err(|error| refused(document, &error))?;
        let scope = scope(document, &geometry, None)?;
        for (formula, function) in self.recorded()? {
            for sum in function.sums() {
                sum.density(&scope, geometry.middle())
                    .map_err(|error| refusal(document, formula, &error))?;
            }
        }
        // Single coordinates are columns of their own, whatever the length of what is written out.
        let whole = self::scope(document, &self.geometry, None)?;
        let observables = observables(document, &scope, Some((&self.geometry, &whole)))?;
        Ok((system, geometry, observables))
    }

    /// Energy and Casimirs, and formulas of the state that the scene records.
    ///
    /// # Errors
    /// [`BuildError`] where one has no code, or looks too far.
    pub fn functions(&self, parameters: &[f64]) -> Result<[LatticeFunctions; 2], BuildError> {
        let dimension = self.geometry.dimension();
        let whole = scope(self.document, &self.geometry, None).map_err(of_lattice)?;
        let (mut functions, mut behind) = (Vec::new(), 0);
        for (place, (formula, function)) in self.recorded().map_err(of_lattice)?.iter().enumerate()
        {
            let outside = function.outside(self.document, (formula, &whole), dimension + behind);
            let outside = outside.map_err(of_lattice)?;
            functions.extend(outside.map(|outside| (place, outside)));
            behind += function.behind();
        }
        let invariants = self.invariants();
        let sums = |selection| LatticeObservables::new(self, parameters, selection);
        Ok([
            LatticeFunctions::new(sums(0..invariants)?, 0, &[], parameters)?,
            LatticeFunctions::new(
                sums(invariants..usize::MAX)?,
                behind,
                &functions,
                parameters,
            )?,
        ])
    }

    /// How many the energy and the Casimirs are.
    fn invariants(&self) -> usize {
        1 + self.document.system.casimirs.len()
    }

    /// Formulas that the run records beside energy and Casimirs, as functions of sums over sites.
    ///
    /// # Errors
    /// Formulas that cannot be read.
    fn recorded(&self) -> Result<Vec<(&'a Located<String>, SiteFunction)>, Refusal> {
        let formulas = self.formulas().into_iter().skip(self.invariants());
        let functions =
            formulas.map(|formula| Ok((formula, SiteFunction::of(self.document, formula)?)));
        functions.collect()
    }

    /// The lattice as a system of numbers, where the run follows tangents; `None` elsewhere.
    ///
    /// # Errors
    /// Those of [`LatticeNumbers::compile`].
    pub fn numbers(&self) -> Result<Option<PoissonSystem>, BuildError> {
        match follows_tangents(self.document) {
            true => Ok(Some(LatticeNumbers::compile(self)?.system.into())),
            false => Ok(None),
        }
    }

    /// Formulas that the run watches: the energy, the Casimirs, then formulas of the state.
    fn formulas(&self) -> Vec<&'a Located<String>> {
        let system = &self.document.system;
        let named = |name: &str| {
            name == "energy"
                || system
                    .casimirs
                    .iter()
                    .any(|(casimir, _)| casimir.value == name)
        };
        let defined = system.define.iter().map(|(name, _)| name);
        let parameters = system.parameters.iter().map(|(name, _)| name);
        let own: Vec<&str> = defined
            .chain(parameters)
            .map(|name| name.value.as_str())
            .collect();
        let recorded = self.document.run.record.observables.iter();
        let recorded = recorded
            .map(|observable| &observable.formula)
            .filter(|formula| {
                let text = &formula.value;
                let is_indicator = asks_for_indicator(text) && !own.contains(&text.as_str());
                let is_shadow = shadow_order(text).is_some();
                !named(text)
                    && !is_indicator
                    && !is_shadow
                    && coordinate(&self.geometry, text).is_none()
            });
        std::iter::once(&system.hamiltonian)
            .chain(system.casimirs.iter().map(|(_, formula)| formula))
            .chain(recorded)
            .collect()
    }
}

/// Asks for the memory of a run at once. Too long a lattice is then an error here, and not the end of the program in
/// the middle of the run. Before a method is built, it has one field at least.
pub(super) fn has_room(
    document: &SceneDocument,
    coordinates: usize,
    fields: usize,
) -> Result<(), Refusal> {
    let each = numbers_a_coordinate(fields) + numbers_of_events(document, fields);
    let numbers = coordinates.saturating_mul(each);
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

/// A system that is not built, with the bracket underlined.
fn refused(document: &SceneDocument, error: &BuildError) -> Refusal {
    let place = document.system.bracket.place();
    Box::new(document.diagnostic(&place, error.to_string(), "here", None))
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
    for (((_, sites), (_, full)), offset) in families {
        for site in 0..*sites {
            let like = match geometry.axes.len() {
                1 => like(site, *sites, *full),
                _ => {
                    let mut place = shorter.place(site);
                    let axes = shorter.axes.iter().zip(&geometry.axes);
                    for (at, (short, whole)) in place.iter_mut().zip(axes) {
                        *at = like(*at, short.length, whole.length);
                    }
                    geometry.site(place)
                }
            };
            short.push(state[offset + like]);
        }
    }
    short
}

/// The place along an axis of `full` sites that is as far from the nearer end as `at` is on one of `length` sites.
fn like(at: usize, length: usize, full: usize) -> usize {
    match at <= length / 2 {
        true => at,
        false => full - (length - at),
    }
}

impl LatticeSource for SceneLattice<'_> {
    fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    fn reach(&self) -> Result<TemplateReach, BuildError> {
        Ok(self.reach)
    }

    fn write_out(&self, geometry: &LatticeGeometry) -> Result<PoissonSystem, BuildError> {
        let own = self.own(geometry);
        let mut written = instantiate(self.document, &own).map_err(of_lattice)?;
        let Some(noise) = &self.noise else {
            return written.system(self.document);
        };
        let further = own.dimension()..geometry.dimension();
        written.rest(further.map(|coordinate| geometry.name(coordinate)));
        let scope = scope(self.document, &own, None).map_err(of_lattice)?;
        let mut terms = Vec::new();
        for site in 0..geometry.length() {
            terms.extend(noise.at(self.document, &scope, geometry, site)?);
        }
        noise.moved(&written.system(self.document)?, Expression::Sum(terms))
    }

    fn densities(
        &self,
        geometry: &LatticeGeometry,
        site: usize,
    ) -> Result<Vec<SiteDensity>, BuildError> {
        let own = self.own(geometry);
        let scope = scope(self.document, &own, None).map_err(of_lattice)?;
        let density = |formula: &Formula, site| {
            let density = formula.density(&scope, site);
            let density = density.map_err(|error| BuildError::Lattice {
                message: error.to_string(),
            })?;
            Ok::<_, BuildError>(SiteDensity {
                constant: density.constant,
                site: density.site,
            })
        };
        let of_text = |formula: &Located<String>, site| {
            density(&parse(self.document, formula).map_err(of_lattice)?, site)
        };
        let watched = self.formulas().into_iter().take(self.invariants());
        let watched = watched.map(|formula| of_text(formula, site));
        let mut densities: Vec<SiteDensity> = watched.collect::<Result<_, BuildError>>()?;
        // Sums of functions stand behind all, and 0 where a function is evaluated.
        let mut behind = Vec::new();
        for (_, function) in self.recorded().map_err(of_lattice)? {
            let alone = match &function {
                SiteFunction::Sum(sum) => density(sum, site)?,
                _ => SiteDensity {
                    constant: 0.into(),
                    site: 0.into(),
                },
            };
            densities.push(alone);
            match (&function, &self.spins) {
                (SiteFunction::OfSums(_, sums), _) => {
                    let sums = sums.iter().map(|sum| density(sum, site));
                    behind.extend(sums.collect::<Result<Vec<_>, _>>()?);
                }
                (SiteFunction::SpinTemperature, Some(spins)) => {
                    let energy = |site| {
                        let energy = of_text(&self.document.system.hamiltonian, site)?;
                        Ok(energy.site)
                    };
                    let of_spins = spins.at(&own, site, energy)?;
                    behind.extend(of_spins.map(|site| SiteDensity {
                        constant: 0.into(),
                        site,
                    }));
                }
                _ => {}
            }
        }
        densities.append(&mut behind);
        if let (Some(noise), Some(energy)) = (&self.noise, densities.first_mut()) {
            let mut terms = noise.at(self.document, &scope, geometry, site)?;
            if noise.has_energy() {
                terms.push(energy.site.clone());
            }
            energy.site = Expression::Sum(terms);
        }
        Ok(densities)
    }
}
