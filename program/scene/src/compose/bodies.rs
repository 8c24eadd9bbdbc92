//! A scene of many bodies: sums over pairs of sites, evaluated in loops.

use leafwise_core::lattice::{LatticeGeometry, TemplateReach};
use leafwise_core::pairs::{BodyFunction, BodyShape, BodySystem, PairMatrix};
use leafwise_core::part::{Family, ParameterDefault, PartInfo};
use leafwise_core::system::{MotionClass, Parameter};
use leafwise_core::{BuildError, PartParameters, PoissonSystem, Registry};
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::definitions::scope;
use super::dense::{DENSE_LIMIT, WRITTEN_LIMIT};
use super::events::events;
use super::geometry::{check_lengths, geometry, one_site};
use super::initial::initial_state;
use super::lattice::has_forms;
use super::lattice_noise::site_channels;
use super::matrices::matrices;
use super::names::{check_code, check_names, coordinate_names, parse};
use super::observables::{RecordedFormula, expression, observables_in, shadow_order};
use super::parts::steppers_of_fields;
use super::reach::{bracket_reach, reach};
use super::site_forces::{Apart, Bodies, SiteForces};
use super::system::{ComposedSystem, check_contradictions, check_sites};
use super::tensor::{Entries, entries};
use super::time::wants_time;
use crate::document::{Convention, Located, ParameterValue, PartSpec, SceneDocument};

/// The fewest sites whose pairs are evaluated in a loop: those of fewer are written out.
const FEWEST_SITES: usize = 16;

/// The number of sites from which on pairs are not written out for an order above 2. Hamilton–Jacobi's coefficients of order
/// 4 are products of forces: for 30 vortices they took minutes to form.
pub(super) const MOST_SITES_OF_HIGH_ORDER: usize = 24;
const HIGH_ORDER: f64 = 2.0;

/// The system of a scene with sums over pairs in loops.
///
/// It is one of numbers, for a stepper that needs no formulas. H is a function of sums over sites and pairs that no
/// template makes, and the bracket couples coordinates of one site. `None` for any other scene.
///
/// # Errors
/// The first thing wrong, underlined in the scene.
pub(super) fn many_bodies(
    document: &SceneDocument,
    registry: &Registry,
) -> Result<Option<ComposedSystem>, Refusal> {
    if !may_be_bodies(document) {
        return Ok(None);
    }
    check_contradictions(document)?;
    check_names(document)?;
    check_sites(document)?;
    check_lengths(document)?;
    let lattice = geometry(document);
    let of_bracket = bracket_reach(document, TemplateReach::default());
    let is_local = of_bracket.is_ok_and(|reach| reach.has_sites_apart());
    if !is_local || reach(document, TemplateReach::default()).is_ok() {
        return Ok(None);
    }
    let whole = scope(document, &lattice, None)?;
    let sums = BodyFormulas {
        document,
        scope: &whole,
        shape: shape(document, &whole, &lattice)?,
    };
    let Some(hamiltonian) = sums.of(&document.system.hamiltonian)? else {
        return Ok(None);
    };
    let mut casimirs = Vec::new();
    for (name, formula) in &document.system.casimirs {
        let Some(casimir) = sums.of(formula)? else {
            return Ok(None);
        };
        casimirs.push((name.value.clone(), casimir));
    }
    let at_sites = match SiteForces::of(document)? {
        Ok(at_sites) => at_sites,
        // A lattice without sums over pairs has words of its own for what repeats nowhere.
        Err(_) if is_template(document)? => return Ok(None),
        Err(apart) => return unless_beside(document, &apart),
    };
    // Written out, steps beside forces have derivatives, and solve their equations by Newton's method.
    if !at_sites.forces.is_empty() && document.system.coordinates() <= WRITTEN_LIMIT {
        return Ok(None);
    }
    let sites = document.system.families[0].1.value;
    if sites < MOST_SITES_OF_HIGH_ORDER && asks_for_shadow(document) {
        return Ok(None);
    }
    let watched = BodySystem {
        shape: sums.shape.clone(),
        variables: coordinate_names(document, &lattice),
        parameters: (document.system.parameters.iter())
            .map(|(name, value)| Parameter {
                name: name.value.clone(),
                value: value.value.value,
            })
            .collect(),
        bracket: bracket_of_a_site(document)?.into_iter().collect(),
        forces: at_sites.forces.clone(),
        hamiltonian,
        casimirs,
        near: initial_state(document).unwrap_or_default(),
    };
    let named = document.method.stepper.as_ref();
    let stepper = named.and_then(|spec| registry.stepper(&spec.name.value).ok());
    let Some(stepper) = stepper else {
        return unless_too_long(document, registry);
    };
    let refused = |error: BuildError| {
        let place = document.system.hamiltonian.place();
        document.diagnostic(&place, error.to_string(), "here", None)
    };
    let system = PoissonSystem::from(watched.compile().map_err(refused)?);
    let site = watched.of_a_site().map_err(refused)?;
    let stepped = at_sites.stepped(document, &watched)?;
    let stepped = match stepped {
        Some(stepped) => Some(PoissonSystem::from(stepped.compile().map_err(refused)?)),
        None => None,
    };
    let moved = stepped.as_ref().unwrap_or(&system);
    let built = stepper.build(moved, &words(named, stepper.info));
    // A motion that it does not take is refused as that of any system.
    let is_beyond = matches!(
        built,
        Err(BuildError::Forces { .. } | BuildError::Friction { .. })
    );
    let serves = stepper.info.serves_numbers.is_some() || built.is_ok() || is_beyond;
    if !serves {
        return unless_too_long(document, registry);
    }
    let initial = initial_state(document)?;
    let events = events(document, &whole)?;
    events.check(document, &initial, &system.parameter_values())?;
    at_sites.check(document, &site, (&initial, &lattice))?;
    Ok(Some(ComposedSystem {
        system,
        near: initial.clone(),
        initial,
        extension: None,
        contact: None,
        noise: site_channels(document, &one_site(document))?,
        bodies: Some(Bodies { site, stepped }),
        observables: observables_in(document, None, |formula, known| {
            let parsed = parse(document, formula).ok();
            let of_sums = match parsed.is_some_and(|parsed| parsed.has_sum()) {
                true => sums.of(formula)?,
                false => None,
            };
            match of_sums {
                Some(function) => Ok(RecordedFormula::Sums(
                    sums.shape.clone(),
                    Box::new(function),
                )),
                None => expression(document, &whole, formula, known).map(RecordedFormula::Written),
            }
        })?,
        events,
    }))
}

/// The words that a scene gives a stepper: some ask for what a loop has not, as flows of whole bodies.
fn words(named: Option<&PartSpec>, info: &PartInfo) -> PartParameters {
    let given = named.into_iter().flat_map(|spec| &spec.parameters);
    given.fold(PartParameters::new(), |words, (key, value)| {
        let mut known = info.parameters.iter();
        let known = known.find(|p| p.name == key.value);
        match (&value.value, known.map(|p| (p.name, p.default))) {
            (ParameterValue::Text(word), Some((name, ParameterDefault::Text(_)))) => {
                words.with(name, word.as_str())
            }
            _ => words,
        }
    })
}

/// Whether a scene is a chain of more than a few sites.
fn may_be_bodies(document: &SceneDocument) -> bool {
    let system = &document.system;
    let Some(((_, length), rest)) = system.families.split_first() else {
        return false;
    };
    system.numbers.is_none()
        && system.variables.is_empty()
        && system.axes.is_empty()
        && rest.iter().all(|(_, own)| own.value == length.value)
        && length.value >= FEWEST_SITES
        && system.coordinates() > DENSE_LIMIT
        && !has_forms(&system.bracket.value, &system.constraints)
        && wants_time(document).is_none()
}

/// Whether the Hamiltonian repeats from site to site: it is no function of sums over pairs.
///
/// # Errors
/// A Hamiltonian that cannot be read.
fn is_template(document: &SceneDocument) -> Result<bool, Refusal> {
    let hamiltonian = parse(document, &document.system.hamiltonian)?;
    let reach = TemplateReach::default().with_hamiltonian(&hamiltonian);
    Ok(reach.is_ok())
}

/// Whether a shadow energy is recorded: its terms are products of forces, as those of a high order.
fn asks_for_shadow(document: &SceneDocument) -> bool {
    let mut observables = document.run.record.observables.iter();
    observables.any(|asked| shadow_order(&asked.formula.value).is_some())
}

/// `None`, for a system whose pairs are written out beside what no loop takes.
///
/// # Errors
/// Too many pairs for that, the formula of what no loop takes underlined.
fn unless_beside(
    document: &SceneDocument,
    apart: &Apart<'_>,
) -> Result<Option<ComposedSystem>, Refusal> {
    let coordinates = document.system.coordinates();
    if coordinates <= WRITTEN_LIMIT {
        return Ok(None);
    }
    let Apart {
        formula,
        kind,
        template,
    } = apart;
    Err(Box::new(document.diagnostic(
        &document.place_in_formula(formula, 0..formula.value.len()),
        format!(
            "{kind} beside a sum over pairs, where it is no template of one site, needs every pair of sites written out, at most \
             {WRITTEN_LIMIT} coordinates, and this system has {coordinates}"
        ),
        "no template of one site",
        Some(format!(
            "write it by the coordinates of one site, as {template}, or shorten the chain, {}{}",
            document.system.shortening(WRITTEN_LIMIT),
            match kind.contains("`forces`") {
                true => "; a force with a potential may be a function of sums in the Hamiltonian",
                false => "",
            }
        )),
    )))
}

/// Whether the scene steps by realization and dynamics of an order at which terms of H multiply.
fn has_high_order(document: &SceneDocument, registry: &Registry) -> bool {
    if document.method.stepper.is_some() {
        return false;
    }
    let Some(dynamics) = &document.method.dynamics else {
        return true;
    };
    let part = registry.dynamics(&dynamics.name.value);
    let is_of_order =
        dynamics.name.value == "auto" || part.is_ok_and(|part| part.info.is_of_order());
    let mut given = dynamics.parameters.iter();
    let order = given.find(|(key, _)| key.value == "order");
    let is_low = order.is_some_and(|(_, value)| match &value.value {
        ParameterValue::Number(number) => number.value <= HIGH_ORDER,
        _ => true,
    });
    is_of_order && !is_low
}

/// `None`, for a system that is written out.
///
/// # Errors
/// Too many pairs for that.
fn unless_too_long(
    document: &SceneDocument,
    registry: &Registry,
) -> Result<Option<ComposedSystem>, Refusal> {
    let system = &document.system;
    let (coordinates, sites) = (system.coordinates(), system.families[0].1.value);
    let is_high = sites >= MOST_SITES_OF_HIGH_ORDER && has_high_order(document, registry);
    if coordinates <= WRITTEN_LIMIT && !is_high {
        return Ok(None);
    }
    let names = |parts: Vec<&'static PartInfo>| -> Vec<&str> {
        parts.iter().map(|info| info.name).collect()
    };
    let forces = &system.forces;
    let motion = match (&forces.friction, forces.keys().is_empty()) {
        (Some(_), _) => MotionClass::OffLeaves,
        (None, false) => MotionClass::OnLeaves,
        (None, true) => MotionClass::Hamiltonian,
    };
    let splitting = registry.family(Family::Splitting).into_iter();
    let splitting = names(splitting.filter(|info| info.takes >= motion).collect());
    let serving = steppers_of_fields(registry, motion);
    let method = &document.method;
    let named = method.stepper.as_ref().or(method.dynamics.as_ref());
    let of = match named {
        Some(spec) => format!("`{}`", spec.name.value),
        None => "a realization with its dynamics".to_owned(),
    };
    let place = named.map_or_else(|| system.hamiltonian.place(), |spec| spec.name.place());
    Err(Box::new(document.diagnostic(
        &place,
        match coordinates <= WRITTEN_LIMIT {
            true => format!(
                "of an order above {HIGH_ORDER} {of} needs the products of all pairs of sites written out, for fewer than \
                 {MOST_SITES_OF_HIGH_ORDER} sites, and this system has {sites}"
            ),
            false => format!(
                "{of} needs every pair of sites written out, at most {WRITTEN_LIMIT} coordinates, and this system has {coordinates}: \
                 its H couples all of them by a sum over pairs, a sum within a sum, or a function of sums"
            ),
        },
        "here",
        Some(format!(
            "steppers that take pairs in a loop: {}{}",
            match splitting.is_empty() {
                true => String::new(),
                false => format!(
                    "{} where H = T + V or the terms of a pair have one exact flow, ",
                    splitting.join(", ")
                ),
            },
            names(serving).join(", ")
        )),
    )))
}

/// {x_a, x_b} of the families at one site, in the paper's convention.
fn bracket_of_a_site(document: &SceneDocument) -> Result<Entries, Refusal> {
    let lattice = one_site(document);
    let scope = scope(document, &lattice, None)?;
    let names = coordinate_names(document, &lattice);
    let entries = entries(document, &scope, &names, &lattice)?.into_iter();
    let entries = entries.map(|(at, entry)| match document.system.convention {
        Convention::HamiltonFirst => (at, entry),
        Convention::HamiltonSecond => (at, Expression::Negate(Box::new(entry))),
    });
    Ok(entries.collect())
}

/// Formulas of a scene as functions of sums over sites and pairs.
struct BodyFormulas<'a> {
    document: &'a SceneDocument,
    scope: &'a Scope,
    shape: BodyShape,
}

/// The numbers of families and sites of a chain, with its matrices.
fn shape(
    document: &SceneDocument,
    scope: &Scope,
    lattice: &LatticeGeometry,
) -> Result<BodyShape, Refusal> {
    let sites = lattice.length();
    let matrices = matrices(document, scope)?.into_iter();
    Ok(BodyShape {
        families: lattice.families.len(),
        sites,
        matrices: matrices
            .filter_map(|(_, numbers)| PairMatrix::new(numbers, sites))
            .collect(),
    })
}

impl BodyFormulas<'_> {
    /// A formula as such a function; `None` where it is none.
    ///
    /// # Errors
    /// A formula that cannot be read, or has no code.
    fn of(&self, formula: &Located<String>) -> Result<Option<BodyFunction>, Refusal> {
        let first = self.shape.dimension();
        let Ok(sums) = parse(self.document, formula)?.pair_sums(self.scope, first) else {
            return Ok(None);
        };
        let function = BodyFunction::of(&sums, &self.shape);
        for sum in &function.sums {
            check_code(self.document, formula, &sum.site)?;
            check_code(self.document, formula, &sum.pair)?;
        }
        Ok(Some(function))
    }
}
