//! Checks of a system that was read: names, sizes, summands.

use std::collections::HashSet;

use super::bracket::BracketSpec;
use super::error::SceneProblemCause;
use super::field::family_of;
use super::located::Located;
use super::reader::{Problems, Table};
use super::system_section::SystemSection;

/// Names that are no identifiers, and names given twice.
pub(super) fn check_names(system: &SystemSection, problems: &mut Problems) {
    let mut seen: HashSet<&str> = HashSet::new();
    let vectors = || system.vectors.iter().chain(&system.variable_vectors);
    let is_component = |name: &&Located<String>| {
        let mut vectors = system.variable_vectors.iter();
        vectors.any(|vector| vector.has(&name.value))
    };
    let variables = system.variables.iter().filter(|name| !is_component(name));
    let of_vectors = system.variable_vectors.iter().map(|vector| &vector.name);
    let declared = variables
        .chain(of_vectors)
        .map(|name| ("variable", name))
        .chain(
            system
                .declared()
                .into_iter()
                .skip(system.variables.len())
                .map(|name| ("family", name)),
        )
        .chain(
            system
                .parameters
                .iter()
                .map(|(name, _)| ("parameter", name)),
        )
        .chain(system.define.iter().map(|(name, _)| ("definition", name)))
        .chain(system.tables.iter().map(|(name, _)| ("table", name)))
        .chain(
            system
                .families
                .iter()
                .skip(system.moving().len())
                .map(|(name, _)| ("parameter", name)),
        )
        .chain((system.matrices.iter()).map(|matrix| ("parameter", &matrix.name)));
    let components = vectors().flat_map(|vector| {
        let is_new = |at: usize| {
            let mut earlier = vector.components[..at].iter();
            !earlier.any(|other| other.value == vector.components[at].value)
        };
        let components = vector.components.iter().enumerate();
        components.map(move |(at, name)| ("component", name, is_new(at)))
    });
    let declared = declared.map(|(kind, name)| (kind, name, seen.insert(&name.value)));
    for (kind, name, is_new) in declared.chain(components) {
        let mut letters = name.value.chars();
        let begins_well = letters
            .next()
            .is_some_and(|c| c.is_alphabetic() || c == '_');
        if !begins_well || !letters.all(|c| c.is_alphanumeric() || c == '_' || c == '\'') {
            problems.push(
                SceneProblemCause::InvalidName {
                    kind,
                    name: name.value.clone(),
                    reason: "a name is a letter followed by letters, digits and underscores",
                },
                name.place(),
            );
        } else if !is_new {
            problems.push(
                SceneProblemCause::Duplicate {
                    name: name.value.clone(),
                },
                name.place(),
            );
        }
    }
}

/// Tables and definitions beside a library system have names that it does not use.
pub(super) fn check_new_names<'a>(
    system: &SystemSection,
    names: impl Iterator<Item = &'a Located<String>>,
    problems: &mut Problems,
) {
    let named = system.parameters.iter().map(|(name, _)| name);
    let named = named.chain(system.define.iter().map(|(name, _)| name));
    let taken: HashSet<&str> = (named.chain(system.declared()))
        .chain(system.tables.iter().map(|(name, _)| name))
        .map(|name| name.value.as_str())
        .collect();
    for name in names {
        if taken.contains(name.value.as_str()) {
            let cause = SceneProblemCause::Duplicate {
                name: name.value.clone(),
            };
            problems.push(cause, name.place());
        }
    }
}

/// Parameters of sites have names of their own.
pub(super) fn check_sites(system: &SystemSection, problems: &mut Problems) {
    let vectors = system.vectors.iter().map(|vector| &vector.name);
    let families = system.families.iter().map(|(name, _)| name).chain(vectors);
    let taken: HashSet<&str> = families.map(|name| name.value.as_str()).collect();
    for (key, _) in &system.sites {
        if let Some(name) = family_of(&key.value).filter(|name| taken.contains(name)) {
            let name = name.to_owned();
            problems.push(SceneProblemCause::Duplicate { name }, key.place());
        }
    }
}

/// Every variable and family is in one summand of a sum.
pub(super) fn check_summands(system: &SystemSection, problems: &mut Problems) {
    let BracketSpec::Sum(summands) = &system.bracket.value else {
        return;
    };
    let declared = system.declared();
    let mut seen: HashSet<&str> = HashSet::new();
    for name in summands.iter().flat_map(|summand| &summand.variables) {
        let valid = declared.iter().map(|name| name.value.as_str());
        if !valid.clone().any(|known| known == name.value) {
            let kind = "variable or family of this system";
            let cause = SceneProblemCause::unknown(kind, &name.value, valid);
            problems.push(cause, name.place());
        } else if !seen.insert(&name.value) {
            problems.push(
                SceneProblemCause::TwoSummands {
                    name: name.value.clone(),
                },
                name.place(),
            );
        }
    }
    let mut left = declared.into_iter();
    if let Some(name) = left.find(|name| !seen.contains(name.value.as_str())) {
        problems.push(
            SceneProblemCause::NoSummand {
                name: name.value.clone(),
            },
            name.place(),
        );
    }
}

/// A matrix of another size than the variables, and no variables at all.
pub(super) fn check_dimension(table: &Table<'_>, system: &SystemSection, problems: &mut Problems) {
    let dimension = system.coordinates();
    if let BracketSpec::LogCanonical(rows) = &system.bracket.value
        && rows.len() != dimension
    {
        problems.push(
            SceneProblemCause::Shape {
                what: "log-canonical".to_owned(),
                found: format!("{} rows", rows.len()),
                expected: format!("one for each of the {dimension} variables"),
            },
            system.bracket.place(),
        );
    }
    if dimension == 0
        && let Some(item) = table.get("variables")
    {
        problems.push(
            SceneProblemCause::Shape {
                what: "variables".to_owned(),
                found: "no entry".to_owned(),
                expected: "at least one name".to_owned(),
            },
            item.place(),
        );
    }
}
