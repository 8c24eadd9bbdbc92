//! Reads the `[system]` table: the Poisson manifold and the Hamiltonian.

use std::collections::HashSet;
use std::sync::Arc;

use leafwise_core::part::PATH;
use leafwise_core::{Origin, PartKind, Registry};
use leafwise_expression::syntax::{Formula, SiteNames};
use toml::de::DeTable;

use super::bracket::read_bracket;
use super::canonical::Coordinates;
use super::equations::{FIND, found_system, has_equations};
use super::error::{ConstantNames, SceneProblemCause};
use super::families::{
    Families, boundaries, chain_length, check_boundaries, on_axes, read_families,
};
use super::field::{FieldSpec, Parameters, family_of, read_parameters, without_sites};
use super::forces::{ForcesSpec, read_forces};
use super::located::{FOUND, Located, Place, Source};
use super::matrices::take_matrices;
use super::noise::read_noise;
use super::numbers::{asks_for_numbers, read_numbers};
use super::reader::{Item, Problems, Table};
use super::site_names::name_sites;
use super::suggest::nearest;
use super::system_checks::{
    check_dimension, check_names, check_new_names, check_sites, check_summands,
};
use super::system_schema::SYSTEM;
use super::system_section::{Convention, SystemSection};
use super::tables::read_tables;
use super::variables::{Variables, read_variables};
use super::vector_formulas::{define_vectors, force_vectors};

/// Reads `[system]`, going to the library when it names one; the fragment used is left in
/// `fragment` as id and text.
pub(super) fn read_system(
    table: &Table<'_>,
    registry: &Registry,
    fragment: &mut Option<(String, String)>,
    problems: &mut Problems,
) -> Option<SystemSection> {
    table.only(&SYSTEM, problems);
    let Some(item) = table.get("library") else {
        if !has_equations(table) {
            return read_inline(table, registry, problems);
        }
        let text = found_system(table, problems)?;
        *fragment = Some((FOUND.to_owned(), text.clone()));
        let mut system = read_fragment(FOUND, &text, registry, problems)?;
        system.forces = read_forces(table, ForcesSpec::default(), problems)?;
        system.noise = read_noise(table, Vec::new(), problems)?;
        return Some(system);
    };
    let id = item.string(problems)?;
    let Ok(part) = registry.system(&id.value) else {
        let ids = system_names(registry);
        problems.push(
            SceneProblemCause::unknown("library system", &id.value, ids),
            item.place(),
        );
        return None;
    };
    let text = match &part.fragment {
        Some(text) if !(part.has_numbers() && asks_for_numbers(table, problems)) => text,
        _ => return read_numbers(table, &id, &part, problems),
    };
    *fragment = Some((id.value.clone(), text.to_string()));
    let mut system = read_fragment(&id.value, text, registry, problems)?;
    let tables = read_tables(table.get("tables"), registry, problems)?;
    check_new_names(&system, tables.iter().map(|(name, _)| name), problems);
    system.tables.extend(tables);
    let define = read_define(table, problems)?;
    check_new_names(&system, define.iter().map(|(name, _)| name), problems);
    system.define.extend(define);
    define_vectors(&mut system, problems);
    system.casimirs = read_casimirs(table, std::mem::take(&mut system.casimirs), problems)?;
    system.forces = read_forces(table, std::mem::take(&mut system.forces), problems)?;
    system.noise = read_noise(table, std::mem::take(&mut system.noise), problems)?;
    override_values(table, &mut system, part.has_numbers(), problems);
    system.library = Some(id);
    Some(system)
}

/// The Casimirs of a `[system]` table; those of a library system that are not given anew stay.
fn read_casimirs(
    table: &Table<'_>,
    known: Vec<(Located<String>, Located<String>)>,
    problems: &mut Problems,
) -> Option<Vec<(Located<String>, Located<String>)>> {
    match table.get("casimirs") {
        // Found ones stand there unless the system cannot be read.
        Some(item) if item.is_word(FIND) => {
            let reason = "the system cannot be read".to_owned();
            problems.push(SceneProblemCause::NoCasimirs { reason }, item.place());
            None
        }
        Some(item) => item.pairs("a table of formulas, or \"find\"", problems, Item::formula),
        None => Some(known),
    }
}

/// The definitions of a `[system]` table.
fn read_define(
    table: &Table<'_>,
    problems: &mut Problems,
) -> Option<Vec<(Located<String>, Located<String>)>> {
    match table.get("define") {
        Some(item) => item.pairs("a table of formulas", problems, Item::formula),
        None => Some(Vec::new()),
    }
}

/// The systems of a registry, those of plugins first.
fn system_names(registry: &Registry) -> Vec<&'static str> {
    let mut systems = registry.listing();
    systems.retain(|(info, _)| info.kind == PartKind::System);
    systems.sort_by_key(|(_, origin)| matches!(origin, Origin::BuiltIn { .. }));
    systems.into_iter().map(|(info, _)| info.name).collect()
}

fn read_fragment(
    id: &str,
    text: &str,
    registry: &Registry,
    problems: &mut Problems,
) -> Option<SystemSection> {
    let source = Source::Library(Arc::from(id));
    let document = match DeTable::parse(text) {
        Ok(document) => document,
        Err(error) => {
            problems.syntax(error.message(), error.span(), (text, source));
            return None;
        }
    };
    let root = Table::new(
        "the system",
        document.get_ref(),
        Place { source, span: 0..0 },
        text,
    );
    let table = root
        .require("system", "[system]", problems)?
        .table("[system]", "a table", problems)?;
    table.only(&SYSTEM[1..], problems);
    read_inline(&table, registry, problems)
}

/// Replaces parameter values and family lengths given beside `library`, and adds parameters of forces; where the system has numbers
/// too, one parameter tells which to take.
fn override_values(
    table: &Table<'_>,
    system: &mut SystemSection,
    has_numbers: bool,
    problems: &mut Problems,
) {
    let has_sites = !system.families.is_empty();
    let skip = |name: &str| has_numbers && name == PATH;
    let parameters = table
        .get("parameters")
        .and_then(|item| read_parameters(item, has_sites, skip, problems));
    let Parameters {
        numbers: parameters,
        formulas,
        sites,
    } = parameters.unwrap_or_default();
    replace_sites(&mut system.sites, sites, problems);
    let is_known = |name: &str| system.parameters.iter().any(|(p, _)| p.value == name);
    let own = OwnFormulas::of(system);
    let (new, parameters): (Vec<_>, Vec<_>) = (parameters.into_iter())
        .partition(|(name, _)| !is_known(&name.value) && own.name_it(&name.value));
    check_new_names(system, new.iter().map(|(name, _)| name), problems);
    system.parameters.extend(new);
    replace(
        &mut system.parameters,
        Some(parameters),
        "parameter of this system",
        problems,
    );
    let (known, unknown): (Vec<_>, Vec<_>) = formulas.into_iter().partition(|(name, _)| {
        let mut numbers = system.parameters.iter();
        numbers.any(|(known, _)| known.value == name.value) || own.name_it(&name.value)
    });
    for (name, _) in unknown {
        let known = system.parameters.iter().map(|(own, _)| own.value.as_str());
        let cause = SceneProblemCause::unknown("parameter of this system", &name.value, known);
        problems.push(cause, name.place());
    }
    define_parameters(system, known, problems);
    let mut names = Vec::new();
    let families = table.get("families").and_then(|item| {
        let length =
            |item: &Item<'_>, problems: &mut Problems| chain_length(item, &mut names, problems);
        item.pairs("a table of lengths", problems, length)
    });
    let vectors = &system.vectors;
    let given = families.into_iter().flatten().flat_map(|(name, length)| {
        let vector = vectors
            .iter()
            .find(|vector| vector.name.value == name.value);
        let of_components: Vec<Located<String>> = match vector {
            None => vec![name],
            Some(vector) => {
                let components = vector.components.iter();
                let family = |c: &Located<String>| name.clone().map(|_| vector.family(&c.value));
                components.map(family).collect()
            }
        };
        of_components
            .into_iter()
            .map(move |name| (name, length.clone()))
    });
    let given = given.collect();
    let mut moving = system.moving().to_vec();
    // Names are those of the sites of all families.
    if let Some(list) = names.first() {
        for (_, length) in &mut moving {
            *length = Located::new(list.value.len(), list.place());
        }
    }
    replace(&mut moving, Some(given), "family of this system", problems);
    system.families = moving;
    add_sites(system, problems);
    name_sites(system, names, problems);
}

/// Names in the formulas that stand beside a library system: they may name parameters that it has not.
struct OwnFormulas(HashSet<String>);

impl OwnFormulas {
    fn of(system: &SystemSection) -> Self {
        let define = system.define.iter().map(|(_, formula)| formula);
        let all = system.forces.formulas().into_iter().chain(define);
        let parsed = all.filter_map(|formula| Formula::parse(&formula.value).ok());
        let names = parsed.flat_map(|formula| {
            let names = formula.references().into_iter().map(str::to_owned);
            names.collect::<Vec<_>>()
        });
        Self(names.collect())
    }

    fn name_it(&self, name: &str) -> bool {
        self.0.contains(name)
    }
}

/// Makes definitions of parameters that are formulas of other ones; beside `library` they take the place of numbers.
fn define_parameters(
    system: &mut SystemSection,
    formulas: Vec<(Located<String>, Located<String>)>,
    problems: &mut Problems,
) {
    let numbers = system.parameters.iter();
    let numbers: HashSet<String> = numbers.map(|(name, _)| name.value.clone()).collect();
    let names = formulas.iter().map(|(name, _)| name.value.clone());
    let known: HashSet<String> = numbers.iter().cloned().chain(names).collect();
    let variables: HashSet<&str> = (system.variables.iter())
        .chain(system.families.iter().map(|(name, _)| name))
        .map(|name| name.value.as_str())
        .collect();
    for (name, formula) in &formulas {
        let parsed = Formula::parse(&formula.value);
        let references = parsed.iter().flat_map(|formula| formula.references());
        let Some(other) = references.into_iter().find(|other| !known.contains(*other)) else {
            continue;
        };
        let reason = if variables.contains(other) {
            format!("`{other}` depends on the state")
        } else {
            let near = nearest(other, known.iter().map(String::as_str));
            let near = near.map(|near| format!("; did you mean `{near}`?"));
            format!("unknown name `{other}`{}", near.unwrap_or_default())
        };
        let cause = SceneProblemCause::NoConstant {
            key: name.value.clone(),
            text: formula.value.clone(),
            reason,
            names: ConstantNames::Parameters,
            is_of_state: variables.contains(other),
        };
        problems.push(cause, formula.place());
    }
    let is_formula = |name: &str| formulas.iter().any(|(own, _)| own.value == name);
    system
        .parameters
        .retain(|(name, _)| !is_formula(&name.value));
    system.define.splice(0..0, formulas);
}

/// Values of parameters of sites beside those that a system has; the later hold.
fn replace_sites(
    declared: &mut Vec<(Located<String>, FieldSpec)>,
    given: Vec<(Located<String>, FieldSpec)>,
    problems: &mut Problems,
) {
    let families = declared.iter().map(|(key, _)| family_of(&key.value));
    let known: Vec<String> = families.flatten().map(str::to_owned).collect();
    for (key, value) in given {
        let name = family_of(&key.value).unwrap_or_default();
        if known.iter().any(|family| family == name) {
            declared.retain(|(before, _)| before.value != key.value);
            declared.push((key, value));
        } else {
            let kind = "parameter of every site of this system";
            let valid = known.iter().map(String::as_str);
            problems.push(SceneProblemCause::unknown(kind, name, valid), key.place());
        }
    }
}

/// Puts a family at rest behind the others for each parameter of sites, as long as the longest of them.
fn add_sites(system: &mut SystemSection, problems: &mut Problems) {
    let longest = system.families.iter().map(|(_, length)| length);
    let longest = longest.max_by_key(|length| length.value).cloned();
    for (key, _) in &system.sites {
        let Some(length) = &longest else {
            without_sites(key, problems);
            continue;
        };
        let name = family_of(&key.value).unwrap_or_default();
        if !system.families.iter().any(|(known, _)| known.value == name) {
            let name = key.clone().map(|_| name.to_owned());
            system.families.push((name, length.clone()));
        }
    }
}

fn replace<T>(
    declared: &mut [(Located<String>, T)],
    given: Option<Vec<(Located<String>, T)>>,
    kind: &'static str,
    problems: &mut Problems,
) {
    for (name, value) in given.into_iter().flatten() {
        match declared
            .iter_mut()
            .find(|(known, _)| known.value == name.value)
        {
            Some(entry) => entry.1 = value,
            None => {
                let valid = declared.iter().map(|(known, _)| known.value.as_str());
                let cause = SceneProblemCause::unknown(kind, &name.value, valid);
                problems.push(cause, name.place());
            }
        }
    }
}

fn read_inline(
    table: &Table<'_>,
    registry: &Registry,
    problems: &mut Problems,
) -> Option<SystemSection> {
    let variables = match table.get("variables") {
        Some(item) => read_variables(item, problems),
        None => Some(Variables::default()),
    };
    let families = match table.get("families") {
        Some(item) => read_families(item, problems),
        None => Some(Families::default()),
    };
    let has_sites = table.get("families").is_some();
    let parameters = match table.get("parameters") {
        Some(item) => read_parameters(item, has_sites, |_| false, problems),
        None => Some(Parameters::default()),
    };
    let define = read_define(table, problems);
    let tables = read_tables(table.get("tables"), registry, problems);
    if table.get("variables").is_none() && table.get("families").is_none() {
        table.require(
            "variables",
            "variables = [\"x1\", \"x2\", \"x3\"]",
            problems,
        );
    }
    let constraints = match table.get("constraints") {
        Some(item) => item.list_of("a list of formulas", problems, Item::formula),
        None => Some(Vec::new()),
    };
    let boundary = match table.get("boundary") {
        Some(item) => boundaries(item, problems).map(Some),
        None => Some(None),
    };
    let is_paired = |item: &Item<'_>| {
        ["canonical", "contact"]
            .into_iter()
            .any(|kind| item.is_word(kind) || item.has_key(kind))
    };
    let tells_sign =
        table.get("convention").is_some() || table.get("bracket").is_some_and(is_paired);
    let convention = match table.get("convention") {
        Some(item) => {
            let words = [
                ("{H,x}", Convention::HamiltonFirst),
                ("{x,H}", Convention::HamiltonSecond),
            ];
            item.word("convention", &words, problems)
        }
        None => Some(Convention::default()),
    };
    let names = variables.as_ref().map(|variables| &variables.names[..]);
    let coordinates = Coordinates::of(
        names.unwrap_or_default(),
        families.as_ref().map_or(&[], |families| &families.scalars),
        match convention.unwrap_or_default() {
            Convention::HamiltonFirst => "-1",
            Convention::HamiltonSecond => "1",
        },
    );
    let bracket = table
        .require("bracket", "bracket = { \"x1,x2\" = \"-x3\" }", problems)
        .and_then(|item| {
            let spec = read_bracket(item, &coordinates, problems)?;
            Some(Located::new(spec, item.place()))
        });
    let hamiltonian = table
        .require("hamiltonian", "hamiltonian = \"x1^2/2 + x2^2/2\"", problems)
        .and_then(|item| item.formula(problems));
    let casimirs = read_casimirs(table, Vec::new(), problems);
    let forces = read_forces(table, ForcesSpec::default(), problems);
    let noise = read_noise(table, Vec::new(), problems);
    let families = families?;
    let (scalars, axes) = on_axes(families.scalars, problems)?;
    let (vectors, names) = (families.vectors, families.names);
    let Parameters {
        numbers: parameters,
        formulas,
        sites,
    } = parameters?;
    let (sites, matrices) = match axes.is_empty() && !scalars.is_empty() {
        true => take_matrices(sites, problems),
        false => (sites, Vec::new()),
    };
    let Variables {
        names: variables,
        vectors: variable_vectors,
    } = variables?;
    let mut system = SystemSection {
        library: None,
        variables,
        variable_vectors,
        defined_vectors: Vec::new(),
        families: scalars,
        axes,
        site_names: SiteNames::default(),
        vectors,
        parameters,
        sites,
        matrices,
        define: define?,
        tables: tables?,
        bracket: bracket?,
        constraints: constraints?,
        boundary: boundary?,
        convention: convention?,
        tells_sign,
        hamiltonian: hamiltonian?,
        casimirs: casimirs?,
        forces: forces?,
        noise: noise?,
        numbers: None,
    };
    check_boundaries(&system, problems);
    define_parameters(&mut system, formulas, problems);
    check_sites(&system, problems);
    add_sites(&mut system, problems);
    name_sites(&mut system, names, problems);
    check_names(&system, problems);
    define_vectors(&mut system, problems);
    force_vectors(&mut system, problems);
    check_dimension(table, &system, problems);
    check_summands(&system, problems);
    Some(system)
}
