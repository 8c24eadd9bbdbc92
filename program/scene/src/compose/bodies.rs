//! A scene of many bodies: sums over pairs of sites, evaluated in loops.

use leafwise_core::lattice::{LatticeGeometry, TemplateReach};
use leafwise_core::pairs::{BodyFunction, BodyShape, BodySum, BodySystem};
use leafwise_core::system::Parameter;
use leafwise_core::{PartParameters, PoissonSystem, Registry};
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::definitions::scope;
use super::dense::DENSE_LIMIT;
use super::events::events;
use super::geometry::{check_lengths, geometry};
use super::initial::initial_state;
use super::lattice::{bracket_reach, has_forms, one_site, reach};
use super::names::{check_code, check_names, coordinate_names, parse};
use super::observables::observables;
use super::system::{ComposedSystem, check_contradictions, check_sites};
use super::tensor::entries;
use super::time::wants_time;
use crate::document::{Convention, Located, SceneDocument};

/// The fewest sites whose pairs are evaluated in a loop: those of fewer are written out.
const FEWEST_SITES: usize = 16;

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
    let stepper = document.method.stepper.as_ref();
    let stepper = stepper.and_then(|spec| registry.stepper(&spec.name.value).ok());
    let Some(stepper) = stepper.filter(|_| may_be_bodies(document)) else {
        return Ok(None);
    };
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
    let sums = Sums {
        document,
        scope: &whole,
        lattice: &lattice,
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
    let system = BodySystem {
        shape: sums.shape(),
        variables: coordinate_names(document, &lattice),
        parameters: (document.system.parameters.iter())
            .map(|(name, value)| Parameter {
                name: name.value.clone(),
                value: value.value.value,
            })
            .collect(),
        bracket: bracket_of_a_site(document)?,
        hamiltonian,
        casimirs,
    };
    let compiled = system.compile().map_err(|error| {
        let place = document.system.hamiltonian.place();
        document.diagnostic(&place, error.to_string(), "here", None)
    })?;
    let system = PoissonSystem::from(compiled);
    let serves = stepper.info.serves_numbers.is_some()
        || stepper.build(&system, &PartParameters::new()).is_ok();
    if !serves {
        return Ok(None);
    }
    let initial = initial_state(document)?;
    let events = events(document, &whole)?;
    events.check(document, &initial, &system.parameter_values())?;
    Ok(Some(ComposedSystem {
        system,
        near: initial.clone(),
        initial,
        extension: None,
        noise: Vec::new(),
        observables: observables(document, &whole, None)?,
        events,
    }))
}

/// Whether a scene is a chain of more than a few sites that nothing moves but its H.
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
        && system.noise.is_empty()
        && system.forces.formulas().is_empty()
        && !has_forms(&system.bracket.value, &system.constraints)
        && wants_time(document).is_none()
}

/// {x_a, x_b} of the families at one site, in the paper's convention.
fn bracket_of_a_site(
    document: &SceneDocument,
) -> Result<Vec<((usize, usize), Expression)>, Refusal> {
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
struct Sums<'a> {
    document: &'a SceneDocument,
    scope: &'a Scope,
    lattice: &'a LatticeGeometry,
}

impl Sums<'_> {
    fn shape(&self) -> BodyShape {
        BodyShape {
            families: self.lattice.families.len(),
            sites: self.lattice.length(),
        }
    }

    /// A formula as such a function; `None` where it is none.
    ///
    /// # Errors
    /// A formula that cannot be read, or has no code.
    fn of(&self, formula: &Located<String>) -> Result<Option<BodyFunction>, Refusal> {
        let BodyShape { families, sites } = self.shape();
        let d = families * sites;
        let Ok(sums) = parse(self.document, formula)?.pair_sums(self.scope, d) else {
            return Ok(None);
        };
        let second = |at: usize| if at % sites == 1 { families } else { 0 };
        let places: Vec<usize> = (0..d).map(|at| at / sites + second(at)).collect();
        let outer: Vec<usize> = (0..d + sums.sums.len())
            .map(|at| at.saturating_sub(d))
            .collect();
        let function = BodyFunction {
            outer: sums.outer.with_variables(&outer),
            sums: (sums.sums.iter())
                .map(|sum| BodySum {
                    site: sum.site.with_variables(&places),
                    pair: sum.pair.with_variables(&places),
                })
                .collect(),
        };
        for sum in &function.sums {
            check_code(self.document, formula, &sum.site)?;
            check_code(self.document, formula, &sum.pair)?;
        }
        Ok(Some(function))
    }
}
