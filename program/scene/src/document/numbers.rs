//! Reads `library = "vendor/name"` where that is a system of numbers.

use std::collections::BTreeMap;
use std::sync::Arc;

use leafwise_core::part::{PATH, ParameterDefault, PartInfo};
use leafwise_core::registry::SystemPart;
use leafwise_core::{BuildError, PartParameters, PoissonSystem};
use leafwise_expression::syntax::SiteNames;

use super::bracket::BracketSpec;
use super::error::SceneProblemCause;
use super::forces::ForcesSpec;
use super::located::{Located, Number, Place};
use super::method::{ParameterValue, read_parameter};
use super::reader::{Problems, Table};
use super::system_section::{Convention, NumbersSystem, SystemSection};

/// Whether the scene asks for the numbers of a system that has formulas too; a wrong word is recorded.
pub(super) fn asks_for_numbers(table: &Table<'_>, problems: &mut Problems) -> bool {
    let mut elsewhere = Problems::default();
    let parameters = table
        .get("parameters")
        .and_then(|item| item.table("parameters", "a table", &mut elsewhere));
    let Some(path) = parameters.as_ref().and_then(|table| table.get(PATH)) else {
        return false;
    };
    let Some(word) = path.string(problems) else {
        return false;
    };
    let words = ["expressions", "numbers"];
    if !words.contains(&word.value.as_str()) {
        problems.push(
            SceneProblemCause::unknown(PATH, &word.value, words),
            word.place(),
        );
    }
    word.value == "numbers"
}

/// Reads a `[system]` table that names the part `id`, found at `place`, which offers numbers.
pub(super) fn read_numbers(
    table: &Table<'_>,
    id: &Located<String>,
    part: &SystemPart,
    problems: &mut Problems,
) -> Option<SystemSection> {
    let given = match table.get("parameters") {
        Some(item) => item.pairs("a table of parameters", problems, read_parameter)?,
        None => Vec::new(),
    };
    if let Some(item) = table.get("families") {
        let advice = format!("`{}` computes numbers and has no families", id.value);
        problems.conflict("library", item, advice);
        return None;
    }
    for key in [
        "define", "tables", "casimirs", "forces", "torque", "damping", "friction", "noise",
    ] {
        if let Some(item) = table.get(key) {
            let advice = format!(
                "`{}` computes numbers, and `{key}` needs a system of formulas",
                id.value
            );
            problems.conflict("library", item, advice);
            return None;
        }
    }
    let info = part.info;
    let mut parameters = PartParameters::new();
    let mut places: BTreeMap<String, Place> = BTreeMap::new();
    for (name, value) in &given {
        let setting = setting(info, name, value, problems)?;
        places.insert(name.value.clone(), value.place());
        parameters = parameters.with(name.value.clone(), setting);
    }
    let system = match part.build(&parameters) {
        Ok(system) => system,
        Err(error) => {
            let place = match &error {
                BuildError::Parameter { parameter, .. } => places.get(parameter).cloned(),
                _ => None,
            };
            let message = error.to_string();
            let place = place.unwrap_or_else(|| id.place());
            problems.push(SceneProblemCause::System { message }, place);
            return None;
        }
    };
    Some(section(id, system, parameters))
}

/// A given value as one of the type that the part declares.
fn setting(
    info: &PartInfo,
    name: &Located<String>,
    value: &Located<ParameterValue>,
    problems: &mut Problems,
) -> Option<leafwise_core::part::ParameterSetting> {
    let Some(declared) = info.parameters.iter().find(|p| p.name == name.value) else {
        let valid = info.parameters.iter().map(|p| p.name);
        let cause = SceneProblemCause::unknown("parameter of this system", &name.value, valid);
        problems.push(cause, name.place());
        return None;
    };
    let (found, expected) = match (&value.value, declared.default) {
        (ParameterValue::Number(number), ParameterDefault::Integer(_)) => (
            number.literal.parse::<i64>().ok().map(Into::into),
            "a whole number",
        ),
        (ParameterValue::Number(number), ParameterDefault::Real(_)) => {
            (Some(number.value.into()), "a number")
        }
        (ParameterValue::Text(word), ParameterDefault::Text(_)) => {
            (Some(word.as_str().into()), "a word in quotes")
        }
        (_, ParameterDefault::Text(_)) => (None, "a word in quotes"),
        (value, ParameterDefault::Formulas(_)) => (value.formulas(), "a list of formulas"),
        (_, ParameterDefault::Real(_)) => (None, "a number"),
        (_, ParameterDefault::Integer(_)) => (None, "a whole number"),
    };
    if found.is_none() {
        let shown = match &value.value {
            ParameterValue::Number(number) => number.literal.clone(),
            ParameterValue::Text(word) => format!("the string \"{word}\""),
            ParameterValue::Flag(flag) => flag.to_string(),
            ParameterValue::Formulas(_) => "a list".to_owned(),
        };
        problems.push(
            SceneProblemCause::WrongType {
                key: name.value.clone(),
                expected: expected.to_owned(),
                found: shown,
            },
            value.place(),
        );
    }
    found
}

/// The section of a system without formulas: its names stand where the scene names it.
fn section(id: &Located<String>, system: PoissonSystem, given: PartParameters) -> SystemSection {
    let here = |text: &str| Located::new(text.to_owned(), id.place());
    let variables = system.variables().iter().map(|name| here(name)).collect();
    let casimirs = system.casimir_names();
    let casimirs = casimirs.into_iter().map(|name| (here(name), here(name)));
    let parameters = system.parameters().iter().map(|parameter| {
        let number = Number {
            literal: parameter.value.to_string(),
            value: parameter.value,
        };
        (here(&parameter.name), Located::new(number, id.place()))
    });
    SystemSection {
        library: Some(id.clone()),
        variables,
        families: Vec::new(),
        axes: Vec::new(),
        site_names: SiteNames::default(),
        sites: Vec::new(),
        matrices: Vec::new(),
        vectors: Vec::new(),
        variable_vectors: Vec::new(),
        defined_vectors: Vec::new(),
        parameters: parameters.collect(),
        define: Vec::new(),
        tables: Vec::new(),
        constraints: Vec::new(),
        bracket: Located::new(BracketSpec::Entries(Vec::new()), id.place()),
        boundary: None,
        convention: Convention::default(),
        tells_sign: false,
        hamiltonian: here(""),
        forces: ForcesSpec::default(),
        noise: Vec::new(),
        casimirs: casimirs.collect(),
        numbers: Some(NumbersSystem {
            system: Arc::new(system),
            given,
        }),
    }
}
