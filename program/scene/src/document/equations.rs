//! Equations of motion, whose bracket and Hamiltonian are found.

use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Expression, Rational};
use leafwise_find::{Equations, Options, Report, find};
use toml::de::DeTable;
use toml_edit::{DocumentMut, InlineTable, value};

use super::error::{ConstantNames, SceneErrors, SceneProblemCause};
use super::field::{Parameters, read_parameters};
use super::located::{Located, Place, Source};
use super::method_table::RewriteError;
use super::overrides::apply_overrides;
use super::reader::{Item, Problems, Table, end_of};
use super::schema::SCENE;
use super::system_schema::SYSTEM;

/// The word in the place of a bracket.
pub(super) const FIND: &str = "find";

/// Whether a `[system]` table has equations in the place of a bracket.
pub(super) fn has_equations(table: &Table<'_>) -> bool {
    let is_word = |item: &Item<'_>| item.is_word(FIND);
    table.get("equations").is_some() || table.get("bracket").is_some_and(is_word)
}

/// The text of the `[system]` table with the bracket and the Hamiltonian of the equations.
pub(super) fn found_system(table: &Table<'_>, problems: &mut Problems) -> Option<String> {
    let item = table.require("bracket", "bracket = \"find\"", problems)?;
    item.word("bracket", &[(FIND, ())], problems)?;
    let place = item.place();
    let equations = read_equations(table, problems)?;
    let report = match find(&equations, Options::default()) {
        Ok(report) => report,
        Err(error) => {
            let message = error.to_string();
            problems.push(SceneProblemCause::System { message }, place);
            return None;
        }
    };
    match report.bracket {
        Some(bracket) => Some(bracket.fragment()),
        None => {
            let cause = SceneProblemCause::NoBracket {
                reason: reason(&report),
            };
            problems.push(cause, place);
            None
        }
    }
}

fn reason(report: &Report) -> String {
    if let Some(never) = &report.never {
        return never.clone();
    }
    let refused = report.refused.iter();
    let reasons: Vec<String> = refused
        .map(|refused| format!("{}: {}", refused.kind.name(), refused.reason))
        .collect();
    reasons.join("; ")
}

/// The equations of a scene with `bracket = "find"`, whose other tables are not looked at; `None` where a bracket is written.
///
/// # Errors
/// Everything found wrong with the equations, with its place.
pub fn equations_of(name: &str, text: &str) -> Result<Option<Equations>, SceneErrors> {
    let mut problems = Problems::default();
    let equations = equations_in(text, &mut problems);
    match (problems.0.is_empty(), equations) {
        (true, equations) => Ok(equations),
        (false, _) => Err(SceneErrors {
            name: name.to_owned(),
            text: text.to_owned(),
            fragment: None,
            problems: problems.0,
        }),
    }
}

fn equations_in(text: &str, problems: &mut Problems) -> Option<Equations> {
    let document = match DeTable::parse(text) {
        Ok(document) => document,
        Err(error) => {
            problems.syntax(error.message(), error.span(), (text, Source::Scene));
            return None;
        }
    };
    let root = Table::new("the scene", document.get_ref(), end_of(text), text);
    root.only(&SCENE, problems);
    let system = root.require("system", "[system]", problems)?;
    let table = system.table("[system]", "a table", problems)?;
    if !has_equations(&table) {
        return None;
    }
    table.only(&SYSTEM, problems);
    if let Some(item) = table.get("bracket") {
        item.word("bracket", &[(FIND, ())], problems)?;
    }
    read_equations(&table, problems)
}

fn read_equations(table: &Table<'_>, problems: &mut Problems) -> Option<Equations> {
    let item = table.require(
        "equations",
        "equations = { q = \"p\", p = \"-sin(q)\" }",
        problems,
    )?;
    let names = match table.get("variables") {
        Some(item) => Some(item.list_of("a list of names", problems, Item::string)?),
        None => None,
    };
    let rows = rows(item, names, problems)?;
    let Parameters {
        numbers, formulas, ..
    } = match table.get("parameters") {
        Some(item) => read_parameters(item, false, |_| false, problems)?,
        None => Parameters::default(),
    };
    for (name, formula) in &formulas {
        let cause = SceneProblemCause::NoConstant {
            key: name.value.clone(),
            text: formula.value.clone(),
            reason: "with `equations` a parameter is a number".to_owned(),
            names: ConstantNames::None,
            is_of_state: false,
        };
        problems.push(cause, formula.place());
    }
    let before = problems.0.len();
    let variables = rows.iter().map(|(name, _)| ("variable", name));
    let parameters = numbers.iter().map(|(name, _)| ("parameter", name));
    let mut seen: Vec<&str> = Vec::new();
    for (kind, name) in variables.chain(parameters) {
        if Scope::check_name(&name.value).is_err() {
            let cause = SceneProblemCause::InvalidName {
                kind,
                name: name.value.clone(),
                reason: "a name is a letter followed by letters, digits and underscores, and no function's",
            };
            problems.push(cause, name.place());
        } else if seen.contains(&name.value.as_str()) {
            let name_twice = name.value.clone();
            problems.push(
                SceneProblemCause::Duplicate { name: name_twice },
                name.place(),
            );
        }
        seen.push(&name.value);
    }
    if problems.0.len() > before || !formulas.is_empty() {
        return None;
    }
    let variables: Vec<String> = rows.iter().map(|(name, _)| name.value.clone()).collect();
    let mut values = Vec::new();
    for (name, number) in &numbers {
        match Rational::parse_decimal(&number.value.literal) {
            Ok(value) => values.push((name.value.clone(), value)),
            Err(error) => {
                let message = error.to_string();
                problems.push(SceneProblemCause::System { message }, number.place());
                return None;
            }
        }
    }
    let of: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    let scope = Scope::new().with_variables(&variables).with_parameters(&of);
    let mut field = Vec::new();
    for (name, formula) in &rows {
        field.push(resolved(&scope, name, formula, problems)?);
    }
    match Equations::new(variables, values, field) {
        Ok(equations) => Some(equations),
        Err(error) => {
            let message = error.to_string();
            problems.push(SceneProblemCause::System { message }, item.place());
            None
        }
    }
}

/// The right sides by the names of the variables, in the order of `variables` where there is one.
fn rows(
    item: &Item<'_>,
    names: Option<Vec<Located<String>>>,
    problems: &mut Problems,
) -> Option<Vec<(Located<String>, Located<String>)>> {
    if item.is_list() {
        let formulas = item.list_of("a list of formulas", problems, Item::formula)?;
        let names = names.unwrap_or_default();
        if names.len() != formulas.len() {
            let cause = SceneProblemCause::Shape {
                what: "equations".to_owned(),
                found: format!("{} formulas", formulas.len()),
                expected: format!("one for each of the {} `variables`", names.len()),
            };
            problems.push(cause, item.place());
            return None;
        }
        return Some(names.into_iter().zip(formulas).collect());
    }
    let pairs = item.pairs("a table of formulas, or a list", problems, Item::formula)?;
    let Some(names) = names else {
        return Some(pairs);
    };
    let mut rows = Vec::new();
    for name in names {
        let Some((_, formula)) = pairs.iter().find(|(key, _)| key.value == name.value) else {
            let cause = SceneProblemCause::MissingKey {
                table: "equations".to_owned(),
                key: name.value.clone(),
                example: format!("equations = {{ {} = \"0\" }}", name.value),
            };
            problems.push(cause, item.place());
            return None;
        };
        rows.push((name, formula.clone()));
    }
    for (key, _) in &pairs {
        if !rows.iter().any(|(name, _)| name.value == key.value) {
            let known = rows.iter().map(|(name, _)| name.value.as_str());
            problems.push(
                SceneProblemCause::unknown("variable", &key.value, known),
                key.place(),
            );
            return None;
        }
    }
    Some(rows)
}

fn resolved(
    scope: &Scope,
    name: &Located<String>,
    formula: &Located<String>,
    problems: &mut Problems,
) -> Option<Expression> {
    let resolved = Formula::parse(&formula.value).and_then(|parsed| parsed.resolve(scope, None));
    match resolved {
        Ok(expression) => Some(expression.unwrap_or_else(|| Expression::Sum(Vec::new()))),
        Err(error) => {
            let message = format!("the equation of {}: {error}", name.value);
            problems.push(SceneProblemCause::System { message }, formula.place());
            None
        }
    }
}

/// A scene's text with another system: a bracket in the place of equations, or a library's system written out. Forces and noise stay.
///
/// # Errors
/// [`RewriteError`] for a text that is not a scene.
pub fn with_system(text: &str, fragment: &str) -> Result<String, RewriteError> {
    let read = |text: &str| {
        text.parse::<DocumentMut>()
            .map_err(|error| RewriteError::Syntax {
                message: error.message().to_owned(),
            })
    };
    let (mut scene, found) = (read(text)?, read(fragment)?);
    let table = RewriteError::NoTable { table: "system" };
    let found = found
        .get("system")
        .and_then(|item| item.as_table())
        .ok_or(table.clone())?;
    let system = scene
        .get_mut("system")
        .and_then(|item| item.as_table_like_mut())
        .ok_or(table)?;
    for key in ["library", "variables", "parameters", "equations", "bracket"] {
        system.remove(key);
    }
    for (key, value) in found.iter() {
        system.insert(key, value.clone());
    }
    Ok(scene.to_string())
}

/// A scene's text with another Hamiltonian, `None` where its `[system]` table has none to replace.
///
/// # Errors
/// [`RewriteError`] for a text that is not a scene.
pub fn with_hamiltonian(text: &str, hamiltonian: &str) -> Result<Option<String>, RewriteError> {
    let scene = text.parse::<DocumentMut>();
    let mut scene = scene.map_err(|error| RewriteError::Syntax {
        message: error.message().to_owned(),
    })?;
    let system = scene
        .get_mut("system")
        .and_then(|item| item.as_table_like_mut());
    let system = system.ok_or(RewriteError::NoTable { table: "system" })?;
    let is_written = system.get("hamiltonian").is_some_and(|item| item.is_str());
    if !is_written {
        return Ok(None);
    }
    system.insert("hamiltonian", value(hamiltonian));
    Ok(Some(scene.to_string()))
}

/// A scene's text for another map of the same system, with these numbers for its parameters if any are given. Of `[run]` the initial state and so many steps stay; what looks at the time, ensembles
/// and sweeps do not.
///
/// # Errors
/// [`RewriteError`] for a text that is not a scene.
pub fn with_plain_run(
    text: &str,
    parameters: Option<&[(String, f64)]>,
    steps: u64,
) -> Result<String, RewriteError> {
    let scene = text.parse::<DocumentMut>();
    let mut scene = scene.map_err(|error| RewriteError::Syntax {
        message: error.message().to_owned(),
    })?;
    let table = |scene: &mut DocumentMut, table: &'static str, kept: &dyn Fn(&str) -> bool| {
        let own = scene
            .get_mut(table)
            .and_then(|item| item.as_table_like_mut());
        let own = own.ok_or(RewriteError::NoTable { table })?;
        let keys: Vec<String> = own.iter().map(|(key, _)| key.to_owned()).collect();
        for key in keys.iter().filter(|key| !kept(key)) {
            own.remove(key);
        }
        Ok::<_, RewriteError>(())
    };
    table(&mut scene, "run", &|key| key == "initial")?;
    scene["run"]["steps"] = value(i64::try_from(steps).unwrap_or(i64::MAX));
    let is_given = |key: &str| key == "parameters" && parameters.is_some();
    table(&mut scene, "system", &|key| !is_given(key))?;
    if let Some(parameters) = parameters.filter(|given| !given.is_empty()) {
        let mut numbers = InlineTable::new();
        for (name, number) in parameters {
            numbers.insert(name, (*number).into());
        }
        scene["system"]["parameters"] = value(numbers);
    }
    for key in ["ensemble", "sweep"] {
        scene.remove(key);
    }
    Ok(scene.to_string())
}

/// The text under overrides, where `casimirs` of its `[system]` is the word `find`. Beside equations these are found with the bracket.
pub(crate) fn asking_for_casimirs(text: &str, overrides: &[(String, String)]) -> Option<String> {
    // Most scenes do not ask.
    let is_word = |text: &str| text.contains(FIND);
    if !is_word(text) && !overrides.iter().any(|(_, value)| is_word(value)) {
        return None;
    }
    let text = apply_overrides(text, overrides, &mut Problems::default())?;
    place_of_casimirs(&text).is_some().then_some(text)
}

/// The refusal of a text that asks for Casimirs.
pub(crate) fn no_casimirs(name: String, text: String, reason: String) -> SceneErrors {
    let mut problems = Problems::default();
    let place = place_of_casimirs(&text).unwrap_or_else(|| end_of(&text));
    problems.push(SceneProblemCause::NoCasimirs { reason }, place);
    SceneErrors {
        name,
        text,
        fragment: None,
        problems: problems.0,
    }
}

fn place_of_casimirs(text: &str) -> Option<Place> {
    let document = DeTable::parse(text).ok()?;
    let mut none = Problems::default();
    let root = Table::new("the scene", document.get_ref(), end_of(text), text);
    let table = root
        .get("system")?
        .table("[system]", "a table", &mut none)?;
    let item = table.get("casimirs").filter(|item| item.is_word(FIND))?;
    (!has_equations(&table)).then(|| item.place())
}

/// A scene's text with these Casimirs, names and formulas, in the place of those that it has.
///
/// # Errors
/// [`RewriteError`] for a text that is not a scene.
pub fn with_casimirs(text: &str, casimirs: &[(String, String)]) -> Result<String, RewriteError> {
    let scene = text.parse::<DocumentMut>();
    let mut scene = scene.map_err(|error| RewriteError::Syntax {
        message: error.message().to_owned(),
    })?;
    let system = scene
        .get_mut("system")
        .and_then(|item| item.as_table_like_mut());
    let system = system.ok_or(RewriteError::NoTable { table: "system" })?;
    let mut table = InlineTable::new();
    for (name, formula) in casimirs {
        table.insert(name, formula.as_str().into());
    }
    system.insert("casimirs", value(table));
    Ok(scene.to_string())
}
