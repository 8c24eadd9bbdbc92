//! Claims about the library texts and the ready scenes that name them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use leafwise_systems::{LibrarySystem, SystemError, all, find, nearest};

const SYSTEM_KEYS: [&str; 10] = [
    "boundary",
    "bracket",
    "casimirs",
    "constraints",
    "convention",
    "define",
    "families",
    "hamiltonian",
    "parameters",
    "variables",
];

fn crate_directory() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn table<'a>(of: &'a toml::Table, key: &str) -> &'a toml::Table {
    of[key]
        .as_table()
        .unwrap_or_else(|| panic!("`{key}` is a table"))
}

/// The bracket's entries by pairs, with none where it is given by a kind's name.
fn entries(system: &toml::Table) -> impl Iterator<Item = (&str, &str)> {
    let entries = table(system, "bracket").iter();
    // An algebra stands for all of them.
    let entries = entries.filter(|(key, _)| *key != "lie-algebra");
    entries.filter_map(|(pair, entry)| Some((pair.as_str(), entry.as_str()?)))
}

/// The formulas of a list.
fn list<'a>(of: &'a toml::Table, key: &str) -> impl Iterator<Item = &'a str> {
    let list = of.get(key).and_then(toml::Value::as_array);
    list.into_iter().flatten().filter_map(toml::Value::as_str)
}

fn names(system: &toml::Table) -> BTreeSet<String> {
    match system.get("variables") {
        Some(variables) => variables
            .as_array()
            .expect("variables are a list")
            .iter()
            .map(|name| name.as_str().expect("a variable is a string").to_owned())
            .collect(),
        None => table(system, "families")
            .iter()
            .flat_map(|(name, family)| match family.get("components") {
                None => vec![name.clone()],
                Some(components) => {
                    let components = components.as_array().expect("components are a list");
                    let of = |component: &toml::Value| {
                        format!("{name}.{}", component.as_str().expect("a name"))
                    };
                    components.iter().map(of).collect()
                }
            })
            .collect(),
    }
}

/// The identifiers of a formula.
fn identifiers(formula: &str) -> impl Iterator<Item = &str> {
    formula
        .split(|c: char| !c.is_alphanumeric() && c != '_' && c != '.')
        .filter(|word| word.starts_with(char::is_alphabetic))
}

fn scene_path(system: &LibrarySystem) -> PathBuf {
    crate_directory()
        .join("../scenes")
        .join(format!("{}.toml", system.id.replace('-', "_")))
}

fn scene(system: &LibrarySystem) -> toml::Table {
    let path = scene_path(system);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"));
    toml::from_str(&text).unwrap_or_else(|error| panic!("{path:?}: {error}"))
}

#[test]
fn every_text_in_the_folder_is_in_the_library_sorted_by_id() {
    let mut files: Vec<String> = fs::read_dir(crate_directory().join("library"))
        .expect("the library folder is readable")
        .map(|entry| entry.expect("an entry is readable").path())
        .map(|path| {
            path.file_stem()
                .expect("a text has a name")
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    files.sort();
    let ids: Vec<&str> = all().iter().map(|system| system.id).collect();
    assert_eq!(ids, files);
}

#[test]
fn every_system_tells_what_it_is_and_where_it_is_written() {
    for system in all() {
        let about = system.about().expect("a library text is well formed");
        for part in [&about.title, &about.summary, &about.orbit] {
            assert!(!part.trim().is_empty(), "{}", system.id);
        }
        assert!(
            (1850..=2100).contains(&about.reference.year),
            "{}",
            system.id
        );
        let line = about.reference.to_string();
        assert!(
            line.contains(&about.reference.title) && !line.contains(", ,"),
            "{line}"
        );
    }
}

#[test]
fn every_system_table_has_the_keys_of_a_scene_and_no_other() {
    for system in all() {
        let text = system.system().expect("a library text is well formed");
        for key in text.keys() {
            assert!(SYSTEM_KEYS.contains(&key.as_str()), "{}: {key}", system.id);
        }
        for key in ["bracket", "casimirs", "convention", "hamiltonian"] {
            assert!(text.contains_key(key), "{}: {key}", system.id);
        }
        assert_ne!(
            text.contains_key("variables"),
            text.contains_key("families"),
            "{}",
            system.id
        );
        assert_eq!(
            text.contains_key("boundary"),
            text.contains_key("families"),
            "{}",
            system.id
        );
        let convention = text["convention"].as_str();
        assert!(
            matches!(convention, Some("{H,x}" | "{x,H}")),
            "{}: {convention:?}",
            system.id
        );
    }
}

#[test]
fn formulas_use_declared_names_and_every_declared_name_is_used() {
    const LANGUAGE: [&str; 11] = [
        "exp", "ln", "sin", "cos", "sqrt", "sum", "pi", "i", "j", "N", "t",
    ];
    for system in all() {
        let text = system.system().expect("a library text is well formed");
        let define = text.get("define").and_then(toml::Value::as_table);
        let define = || define.into_iter().flatten();
        let formulas: Vec<&str> = entries(&text)
            .flat_map(|(pair, entry)| [Some(pair), Some(entry)])
            .chain(list(table(&text, "bracket"), "one-form").map(Some))
            .chain(table(&text, "casimirs").values().map(toml::Value::as_str))
            .chain(define().map(|(_, formula)| formula.as_str()))
            .chain([text["hamiltonian"].as_str()])
            .map(|formula| formula.expect("a formula is a string"))
            .collect();
        let used: BTreeSet<&str> = formulas
            .iter()
            .flat_map(|formula| identifiers(formula))
            .collect();

        let mut declared = names(&text);
        declared.extend(define().map(|(name, _)| name.clone()));
        if let Some(parameters) = text.get("parameters").and_then(toml::Value::as_table) {
            // Those of every site by the family's name.
            let names = parameters.keys().map(|key| key.trim_end_matches("[i]"));
            declared.extend(names.map(str::to_owned));
        }
        for name in &used {
            let known = declared.contains(*name) || LANGUAGE.contains(name);
            assert!(known, "{}: `{name}` is not declared", system.id);
        }
        // A one-form has a component for each variable.
        let in_a_form = match table(&text, "bracket").contains_key("one-form") {
            true => names(&text),
            false => BTreeSet::new(),
        };
        for name in &declared {
            assert!(
                used.contains(name.as_str()) || in_a_form.contains(name),
                "{}: `{name}` is not used",
                system.id
            );
        }
    }
}

#[test]
fn bracket_entries_name_each_pair_of_variables_once() {
    for system in all() {
        let text = system.system().expect("a library text is well formed");
        let known = names(&text);
        let mut seen = BTreeSet::new();
        for (pair, _) in entries(&text) {
            let (left, right) = pair.split_once(',').expect("an entry names two variables");
            for side in [left, right] {
                let name = side.split('[').next().unwrap_or(side);
                assert!(known.contains(name), "{}: {pair}", system.id);
            }
            assert_ne!(left, right, "{}", system.id);
            let unordered = if left < right {
                (left, right)
            } else {
                (right, left)
            };
            assert!(
                seen.insert(unordered),
                "{}: {pair} is given twice",
                system.id
            );
        }
    }
}

#[test]
fn defaults_fit_the_dimension_and_step_forward() {
    for system in all() {
        let text = system.system().expect("a library text is well formed");
        let defaults = system.defaults().expect("a library text is well formed");
        assert!(defaults.time_step > 0.0, "{}", system.id);
        match &defaults.initial {
            toml::Value::Array(state) => {
                assert_eq!(Ok(state.len()), system.dimension(), "{}", system.id);
            }
            toml::Value::Table(state) => {
                let families: Vec<String> = names(&text)
                    .iter()
                    .map(|name| format!("{name}[i]"))
                    .collect();
                assert!(state.keys().eq(families.iter()), "{}: {state:?}", system.id);
            }
            other => panic!("{}: initial is {other:?}", system.id),
        }
    }
}

#[test]
fn a_system_is_found_by_its_id_and_by_nothing_else() {
    for system in all() {
        assert_eq!(find(system.id), Some(system));
    }
    for unknown in ["", "rigid_body", "Rigid-Body", "zeta"] {
        assert_eq!(find(unknown), None);
    }
}

#[test]
fn a_misspelt_id_leads_to_the_one_meant() {
    for (misspelt, meant) in [
        ("rigid_body", "rigid-body"),
        ("rigidbody", "rigid-body"),
        ("lotka-voltera", "lotka-volterra"),
        ("so-4", "so4"),
        ("threewave", "three-wave"),
    ] {
        assert_eq!(nearest(misspelt), Some(meant));
    }
    assert_eq!(nearest("quux"), None);
}

#[test]
fn a_broken_text_is_a_typed_error() {
    let broken = |text| LibrarySystem { id: "broken", text };
    assert!(matches!(
        broken("[about").about(),
        Err(SystemError::Malformed { .. })
    ));
    assert!(matches!(
        broken("[about]\ntitle = \"only\"").about(),
        Err(SystemError::Malformed { .. })
    ));
    assert_eq!(
        broken("").defaults(),
        Err(SystemError::MissingTable {
            id: "broken".to_owned(),
            table: "default"
        })
    );
    assert_eq!(
        broken("[system]").dimension(),
        Err(SystemError::NoVariables {
            id: "broken".to_owned()
        })
    );
}

#[test]
fn every_system_has_a_ready_scene_that_observes_its_casimirs() {
    for system in all() {
        let scene = scene(system);
        let tables: Vec<&str> = scene.keys().map(String::as_str).collect();
        assert_eq!(tables, ["method", "run", "system"], "{}", system.id);

        let stated = system.system().expect("a library text is well formed");
        let library = toml::Table::from_iter([("library".to_owned(), system.id.into())]);
        let own = table(&scene, "system");
        assert!(*own == library || *own == stated, "{}: {own:?}", system.id);

        let run = table(&scene, "run");
        let defaults = system.defaults().expect("a library text is well formed");
        assert_eq!(run["initial"], defaults.initial, "{}", system.id);
        let method = table(&scene, "method");
        assert_eq!(
            method.contains_key("pace"),
            defaults.paced.is_some(),
            "{}",
            system.id
        );
        if let Some(paced) = &defaults.paced {
            assert_eq!(method["pace"].as_str(), Some(paced.pace.as_str()));
            assert_eq!(method["time-step"].as_float(), Some(paced.time_step));
            let number = |value: &toml::Value| {
                value
                    .as_float()
                    .or(value.as_integer().map(|whole| whole as f64))
            };
            assert_eq!(number(&run["until"]), Some(paced.until));
            assert_eq!(number(&run["record"]["interval"]), Some(paced.interval));
        }
        let observed: BTreeSet<&str> = table(run, "record")["observables"]
            .as_array()
            .expect("observables are a list")
            .iter()
            .filter_map(toml::Value::as_str)
            .collect();
        let expected: BTreeSet<&str> = table(&stated, "casimirs")
            .keys()
            .map(String::as_str)
            .chain(["energy"])
            .collect();
        assert_eq!(observed, expected, "{}", system.id);
    }
}

#[test]
fn the_rigid_body_scene_spells_the_library_system_out() {
    let system = find("rigid-body").expect("the rigid body is in the library");
    let stated = system.system().expect("a library text is well formed");
    assert_eq!(scene(system)["system"].as_table(), Some(&stated));
}

#[test]
fn reference_flows_start_from_the_default_states() {
    let text = fs::read_to_string(crate_directory().join("reference/flows.json"))
        .expect("the reference flows are readable");
    let report: serde_json::Value = serde_json::from_str(&text).expect("the file is JSON");
    let flows = report["flows"].as_array().expect("flows are a list");
    assert_eq!(flows.len(), 14);
    let numbers = |list: &serde_json::Value| -> Vec<f64> {
        list.as_array()
            .expect("a state is a list")
            .iter()
            .map(|number| {
                number
                    .as_str()
                    .expect("a decimal string")
                    .parse()
                    .expect("a number")
            })
            .collect()
    };
    for flow in flows {
        let id = flow["system"].as_str().expect("a flow names its system");
        let system = find(id).unwrap_or_else(|| panic!("`{id}` is in the library"));
        let initial: Vec<f64> = system
            .defaults()
            .expect("a library text is well formed")
            .initial
            .as_array()
            .expect("these systems have listed variables")
            .iter()
            .map(|value| value.as_float().expect("a float"))
            .collect();
        assert_eq!(numbers(&flow["initial"]), initial, "{id}");
        assert_eq!(numbers(&flow["final"]).len(), initial.len(), "{id}");
    }
}
