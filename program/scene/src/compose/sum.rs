//! The summands of a direct sum of brackets, each as a scene of its own.

use leafwise_core::lattice::LatticeGeometry;
use std::collections::BTreeSet;

use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::definitions::scope;
use super::keys::pair;
use super::names::{coordinate_names, parse_text};
use crate::document::{BracketSpec, ForcesSpec, Located, Place, SceneDocument, SummandSpec};

/// A summand: the scene with its variables, families and bracket alone.
#[derive(Clone, Debug)]
pub(super) struct Summand {
    pub document: SceneDocument,
    pub scope: Scope,
    /// Of its own coordinates.
    pub names: Vec<String>,
    /// Of its families.
    pub lattice: LatticeGeometry,
    /// Where its coordinates stand among those of the scene.
    pub places: Vec<usize>,
}

impl Summand {
    /// Whether its tensor is made of a form or with constraints.
    pub fn is_formed(&self) -> bool {
        let system = &self.document.system;
        let bracket = &system.bracket.value;
        let is_form = matches!(bracket, BracketSpec::OneForm(_) | BracketSpec::TwoForm(_));
        is_form || !system.constraints.is_empty()
    }
}

/// Summands of a scene's bracket, with its families as long as those of `lattice`. The list is empty where the bracket is no
/// sum.
///
/// # Errors
/// A formula of a summand that names a variable of another one. A definition that is wrong.
pub(super) fn summands(
    document: &SceneDocument,
    lattice: &LatticeGeometry,
) -> Result<Vec<Summand>, Refusal> {
    let BracketSpec::Sum(specs) = &document.system.bracket.value else {
        return Ok(Vec::new());
    };
    let specs = specs.iter();
    specs.map(|spec| summand(document, spec, lattice)).collect()
}

fn summand(
    document: &SceneDocument,
    spec: &SummandSpec,
    lattice: &LatticeGeometry,
) -> Result<Summand, Refusal> {
    let foreign = foreign_names(document, spec);
    check_formulas(document, spec, &foreign)?;
    let whole = &document.system;
    let mut own = document.clone();
    let system = &mut own.system;
    let names = spec.variables.iter();
    let families = names.flat_map(|name| whole.families_of(&name.value));
    let at =
        |family: &(Located<String>, _)| whole.families.iter().position(|(f, _)| *f == family.0);
    // Every summand may name the parameters of sites.
    let at_rest = whole.moving().len()..whole.families.len();
    let families: Vec<usize> = families.filter_map(at).chain(at_rest).collect();
    system.variables = spec.variables.clone();
    system
        .variables
        .retain(|name| whole.families_of(&name.value).next().is_none());
    let own_names = spec.variables.iter();
    system
        .vectors
        .retain(|v| own_names.clone().any(|name| name.value == v.name.value));
    system.families = families
        .iter()
        .map(|at| whole.families[*at].clone())
        .collect();
    system
        .define
        .retain(|(name, _)| !foreign.contains(name.value.as_str()));
    system.bracket = spec.bracket.clone();
    system.constraints = spec.constraints.clone();
    system.forces = ForcesSpec::default();
    let variable = |name: &Located<String>| {
        let mut variables = whole.variables.iter();
        variables.position(|variable| variable.value == name.value)
    };
    let mut places: Vec<usize> = system.variables.iter().filter_map(variable).collect();
    for at in &families {
        let start = whole.variables.len() + lattice.offsets()[*at];
        places.extend(start..start + lattice.families[*at].1);
    }
    let lattice = lattice.of_families(families);
    Ok(Summand {
        scope: scope(&own, &lattice, None)?,
        names: coordinate_names(&own, &lattice),
        document: own,
        lattice,
        places,
    })
}

/// The variables of the other summands, and the definitions that lead to them.
fn foreign_names<'a>(document: &'a SceneDocument, spec: &SummandSpec) -> BTreeSet<&'a str> {
    let system = &document.system;
    let is_own = |name: &&Located<String>| spec.variables.iter().any(|own| own.value == name.value);
    let mut foreign = BTreeSet::new();
    for name in system.declared().into_iter().filter(|name| !is_own(name)) {
        let families = system.families_of(&name.value);
        foreign.insert(name.value.as_str());
        foreign.extend(families.map(|(family, _)| family.value.as_str()));
    }
    loop {
        let leads = |(name, formula): &&(Located<String>, Located<String>)| {
            !foreign.contains(name.value.as_str())
                && first_of(document, formula, &foreign).is_some()
        };
        let Some((name, _)) = system.define.iter().find(leads) else {
            return foreign;
        };
        foreign.insert(&name.value);
    }
}

/// The first of these names that a formula names.
fn first_of<'a>(
    document: &SceneDocument,
    formula: &Located<String>,
    names: &BTreeSet<&'a str>,
) -> Option<&'a str> {
    let parsed = parse_text(document, &formula.value).ok()?;
    let referred = parsed.references();
    names.iter().copied().find(|name| referred.contains(name))
}

fn check_formulas(
    document: &SceneDocument,
    spec: &SummandSpec,
    foreign: &BTreeSet<&str>,
) -> Result<(), Refusal> {
    let couples = |place: &Place, what: &str, name: &str| {
        let own: Vec<&str> = spec.variables.iter().map(|v| v.value.as_str()).collect();
        let own = own.join(", ");
        Err(Box::new(document.diagnostic(
            place,
            format!("{what} of the summand of {own} names `{name}`, which is not one of its variables"),
            "couples two summands",
            Some(format!(
                "in a direct sum brackets of variables of different summands are 0, and the others depend on their own: write \
                 `{name}` into variables, or couple the summands by the Hamiltonian"
            )),
        )))
    };
    let formula = |formula: &Located<String>| match first_of(document, formula, foreign) {
        None => Ok(()),
        Some(name) => couples(
            &document.place_in_formula(formula, 0..formula.value.len()),
            "a formula",
            name,
        ),
    };
    if let BracketSpec::Entries(entries)
    | BracketSpec::Contact(entries)
    | BracketSpec::TwoForm(entries) = &spec.bracket.value
    {
        for (key, _) in entries {
            let named = pair(document, key).ok();
            let named = named.iter().flat_map(|(a, b)| [a.name(), b.name()]);
            if let Some(name) = named.into_iter().find(|name| foreign.contains(name)) {
                return couples(&key.place(), "an entry", name);
            }
        }
    }
    let own = spec.bracket.value.formulas();
    own.into_iter().try_for_each(formula)?;
    spec.constraints.iter().try_for_each(formula)
}
