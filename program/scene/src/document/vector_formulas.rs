//! Formulas of vectors, written out for their components.

use leafwise_expression::syntax::Formula;

use super::error::SceneProblemCause;
use super::field::FieldSpec;
use super::forces::{ByCoordinate, OneFormSpec};
use super::located::{Located, Place, Source};
use super::reader::{Item, Problems};
use super::run::ObservableSpec;
use super::system_section::{SystemSection, VectorFamily};
use super::variables::COMPONENTS;

/// The formulas of a vector's components with the components' letters; `None` for a number, and where errors are told later.
fn components(
    system: &SystemSection,
    name: &str,
    formula: &Located<String>,
) -> Option<Vec<(&'static str, Located<String>)>> {
    let vectors = system.named_vectors();
    if vectors.is_empty() {
        return None;
    }
    let parts = Formula::parse(&formula.value).ok()?.components(&vectors);
    let parts = parts.ok().flatten()?;
    if parts.len() > COMPONENTS.len() {
        return None;
    }
    let texts = COMPONENTS.into_iter().zip(parts);
    let texts = texts.map(|(letter, part)| (letter, written(&format!("{name}.{letter}"), &part)));
    Some(texts.collect())
}

/// A formula with a text of its own: errors underline it there.
fn written(name: &str, part: &Formula) -> Located<String> {
    let text = part.to_string();
    let line = format!("{name} = \"{text}\"");
    let span = line.len() - text.len() - 2..line.len();
    Located::new(
        text,
        Place {
            span,
            source: Source::Override(line.into()),
        },
    )
}

/// Writes definitions that are vectors out, whatever their order: `L = "cross(r, p)"` defines `L.x`, `L.y` and `L.z`.
pub(super) fn define_vectors(system: &mut SystemSection) {
    loop {
        let mut all = system.define.iter().enumerate();
        let next = all.find_map(|(at, (name, formula))| {
            let parts = components(system, &name.value, formula)?;
            Some((at, name.clone(), parts))
        });
        let Some((at, name, parts)) = next else {
            return;
        };
        let letters = parts.iter().map(|(letter, _)| *letter);
        let vector = VectorFamily {
            components: letters
                .map(|letter| Located::new(letter.to_owned(), name.place()))
                .collect(),
            name: name.clone(),
        };
        let parts = parts.into_iter().map(|(letter, formula)| {
            let component = name.clone().map(|_| vector.family(letter));
            (component, formula)
        });
        system.define.splice(at..=at, parts.collect::<Vec<_>>());
        system.defined_vectors.push(vector);
    }
}

/// Writes forces on vectors out: `p = "-0.1*p"` is a formula for each of `p.x`, `p.y` and `p.z`.
pub(super) fn force_vectors(system: &mut SystemSection) {
    let Some(OneFormSpec::Named(entries)) = system
        .forces
        .one_form
        .as_ref()
        .map(|located| &located.value)
    else {
        return;
    };
    let mut written = ByCoordinate::new();
    for (key, formula) in entries {
        let parts = system.components_of_key(&key.value);
        let formulas = components(system, &key.value, formula);
        match parts.zip(formulas) {
            Some((keys, formulas)) if keys.len() == formulas.len() => {
                let named = keys.into_iter().zip(formulas);
                written
                    .extend(named.map(|(name, (_, formula))| (key.clone().map(|_| name), formula)));
            }
            _ => written.push((key.clone(), formula.clone())),
        }
    }
    if let Some(one_form) = &mut system.forces.one_form {
        one_form.value = OneFormSpec::Named(written);
    }
}

/// Writes observables that are vectors out: `{ L = "cross(r, p)" }` has the columns `L.x`, `L.y` and `L.z`.
pub(super) fn observe_vectors(
    system: Option<&SystemSection>,
    observables: Vec<ObservableSpec>,
) -> Vec<ObservableSpec> {
    let Some(system) = system else {
        return observables;
    };
    let each = observables.into_iter().flat_map(|spec| {
        let heading = spec.heading().to_owned();
        let Some(parts) = components(system, &heading, &spec.formula) else {
            return vec![spec];
        };
        let place = spec.formula.place();
        let named = parts.into_iter().map(|(letter, formula)| ObservableSpec {
            name: Some(Located::new(format!("{heading}.{letter}"), place.clone())),
            formula,
        });
        named.collect()
    });
    each.collect()
}

/// Initial values of a vector by a list, `r = [1, 0, 0]`, one formula or number for each component; `None` for another entry, or after
/// a problem.
pub(super) fn read_vector(
    item: &Item<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<Vec<(Located<String>, FieldSpec)>> {
    let keys = system?.components_of_key(&item.key.value)?;
    if !item.is_list() {
        return None;
    }
    let formulas = item.list_of("a list of formulas or numbers", problems, Item::formula)?;
    if formulas.len() != keys.len() {
        let cause = SceneProblemCause::Shape {
            what: item.title.clone(),
            found: format!("{} entries", formulas.len()),
            expected: format!("{}, one for each of {}", keys.len(), keys.join(", ")),
        };
        problems.push(cause, item.place());
        return Some(Vec::new());
    }
    let named = keys.into_iter().zip(formulas);
    let fields = named.map(|(name, formula)| {
        let key = item.key.clone().map(|_| name);
        (key, FieldSpec::Formula(formula))
    });
    Some(fields.collect())
}
