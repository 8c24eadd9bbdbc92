//! Formulas of vectors, written out for their components.

use leafwise_expression::syntax::{Formula, Scope};

use super::error::SceneProblemCause;
use super::field::FieldSpec;
use super::forces::{ByCoordinate, ComponentsSpec};
use super::located::{Located, Place, Source};
use super::observable::ObservableSpec;
use super::reader::{Item, Problems};
use super::system_section::{SystemSection, VectorFamily};
use super::variables::COMPONENTS;

/// Names of the energy, the time and the derivative.
const TAKEN: [&str; 3] = ["energy", "t", "D"];

/// The formulas of a vector's components with the components' letters; `None` for a number, and where errors are told later.
fn components(
    system: &SystemSection,
    name: &str,
    formula: &Located<String>,
) -> Option<Vec<(String, Located<String>)>> {
    let vectors = system.named_vectors();
    if vectors.is_empty() {
        return None;
    }
    let parsed = Formula::parse(&formula.value).ok()?;
    let parts = parsed.components(&vectors).ok().flatten()?;
    let letters = letters(system, &parsed, parts.len())?;
    let texts = letters.into_iter().zip(parts);
    let texts = texts.map(|(letter, part)| {
        let formula = written(&format!("{name}.{letter}"), &part);
        (letter, formula)
    });
    Some(texts.collect())
}

/// The letters of so many components: x, y and z, and of more those of the first vector in the formula that has as many.
fn letters(system: &SystemSection, formula: &Formula, count: usize) -> Option<Vec<String>> {
    if count <= COMPONENTS.len() {
        let letters = COMPONENTS[..count].iter();
        return Some(letters.map(|letter| (*letter).to_owned()).collect());
    }
    let named = formula.references();
    let mut vectors = system.all_vectors();
    let alike = vectors.find(|vector| {
        vector.components.len() == count && named.contains(vector.name.value.as_str())
    });
    let letters = alike?.components.iter();
    Some(letters.map(|letter| letter.value.clone()).collect())
}

/// The letters and formulas of a vector that is named alone: those of its own components.
fn components_by_name(
    system: &SystemSection,
    formula: &Located<String>,
) -> Option<Vec<(String, Located<String>)>> {
    let mut vectors = system.all_vectors();
    let vector = vectors.find(|vector| vector.name.value == formula.value.trim())?;
    let components = vector.components.iter().map(|letter| {
        let text = vector.family(&letter.value);
        (letter.value.clone(), formula.clone().map(|_| text))
    });
    let is_single = !system
        .vectors
        .iter()
        .any(|family| family.name == vector.name);
    is_single.then(|| components.collect())
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
///
/// Records names that a vector cannot have: those of invariants, of the time and of functions.
pub(super) fn define_vectors(system: &mut SystemSection, problems: &mut Problems) {
    loop {
        let mut all = system.define.iter().enumerate();
        let next = all.find_map(|(at, (name, formula))| {
            let parts = components(system, &name.value, formula)?;
            Some((at, name.clone(), parts))
        });
        let Some((at, name, parts)) = next else {
            return;
        };
        let mut casimirs = system.casimirs.iter();
        let is_taken = casimirs.any(|(casimir, _)| *casimir.value == *name.value)
            || TAKEN.contains(&name.value.as_str())
            || Scope::check_name(&name.value).is_err();
        if is_taken {
            let cause = SceneProblemCause::InvalidName {
                kind: "definition",
                name: name.value.clone(),
                reason: "a vector has a name of its own: this one is a function, an invariant or the time",
            };
            problems.push(cause, name.place());
        }
        let letters = parts.iter().map(|(letter, _)| letter.clone());
        let vector = VectorFamily {
            components: letters
                .map(|letter| Located::new(letter, name.place()))
                .collect(),
            name: name.clone(),
        };
        let parts = parts.into_iter().map(|(letter, formula)| {
            let component = name.clone().map(|_| vector.family(&letter));
            (component, formula)
        });
        system.define.splice(at..=at, parts.collect::<Vec<_>>());
        system.defined_vectors.push(vector);
    }
}

/// Writes forces on vectors out: `p = "-0.1*p"` is a formula for each of `p.x`, `p.y` and `p.z`.
///
/// Records a component that has a force of its own too.
pub(super) fn force_vectors(system: &mut SystemSection, problems: &mut Problems) {
    let mut write_out = |components: &Option<Located<ComponentsSpec>>| {
        let mut written = components.clone()?;
        if let ComponentsSpec::Named(entries) = &mut written.value {
            *entries = by_components(system, entries, problems);
        }
        Some(written)
    };
    let forces = &system.forces;
    let (one_form, friction) = (write_out(&forces.one_form), write_out(&forces.friction));
    system.forces.one_form = one_form;
    system.forces.friction = friction;
}

/// Formulas by coordinates, those of vectors written out for their components.
///
/// Records a component that has a formula of its own too.
pub(super) fn by_components(
    system: &SystemSection,
    entries: &ByCoordinate,
    problems: &mut Problems,
) -> ByCoordinate {
    let mut written_out = ByCoordinate::new();
    for (key, formula) in entries {
        let parts = system.components_of_key(&key.value);
        let formulas = components(system, &key.value, formula);
        match parts.zip(formulas) {
            Some((keys, formulas)) if keys.len() == formulas.len() => {
                let named = keys.into_iter().zip(formulas);
                written_out
                    .extend(named.map(|(name, (_, formula))| (key.clone().map(|_| name), formula)));
            }
            _ => written_out.push((key.clone(), formula.clone())),
        }
    }
    check_components_once(system, entries.iter().map(|(key, _)| key), problems);
    written_out
}

/// Records a vector and one of its components that are both given, as `p` and `p.x`.
pub(super) fn check_components_once<'a>(
    system: &SystemSection,
    keys: impl Iterator<Item = &'a Located<String>> + Clone,
    problems: &mut Problems,
) {
    let plain = |key: &str| key.replace(char::is_whitespace, "");
    for vector in keys.clone() {
        let Some(components) = system.components_of_key(&vector.value) else {
            continue;
        };
        let components: Vec<String> = components.iter().map(|key| plain(key)).collect();
        let both = keys
            .clone()
            .filter(|key| components.contains(&plain(&key.value)));
        for component in both {
            let cause = SceneProblemCause::Conflict {
                first: vector.value.clone(),
                second: component.value.clone(),
                advice: format!(
                    "`{}` stands for {}: give the whole vector, or each component by itself",
                    vector.value,
                    components.join(", ")
                ),
            };
            problems.push(cause, component.place());
        }
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
        let parts = components_by_name(system, &spec.formula)
            .or_else(|| components(system, &heading, &spec.formula));
        let Some(parts) = parts else {
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
    if !item.is_list() {
        return None;
    }
    let Some(system) = system else {
        // What the system has wrong is told there: whether this is a vector is not known.
        return Some(Vec::new());
    };
    let keys = system.components_of_key(&item.key.value)?;
    let formulas = item.list_of("a list of formulas or numbers", problems, Item::formula);
    let Some(formulas) = formulas else {
        return Some(Vec::new());
    };
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
