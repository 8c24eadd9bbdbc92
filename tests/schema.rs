//! The JSON Schema of scenes says what the reader does: what it accepts, and what it refuses for a key or a kind of value.

use std::fs;
use std::path::Path;

use leafwise::core::Registry;
use leafwise::prelude::SceneDocument;
use leafwise::scene::document::{Fault, faults, json_schema};
use leafwise::stress::SCENES_FOR_FAULTS;
use serde_json::Value;

/// Whether a value fits a schema, by the rules of JSON Schema for the words that are used.
///
/// # Panics
/// When the schema has another word.
fn fits(schema: &Value, value: &Value) -> bool {
    let schema = schema.as_object().expect("a schema is an object");
    let known = |name: &str| {
        schema
            .get("properties")
            .is_some_and(|of| of.get(name).is_some())
    };
    let pattern = |pattern: &str, text: &str| match pattern {
        "^[^,]+,[^,]+$" => {
            matches!(text.split(',').collect::<Vec<_>>()[..], [a, b] if !(a.is_empty() || b.is_empty()))
        }
        "^[^/]+/[^/]+$" => {
            matches!(text.split('/').collect::<Vec<_>>()[..], [a, b] if !(a.is_empty() || b.is_empty()))
        }
        other => panic!("a pattern `{other}`"),
    };
    let is = |word: &str| match word {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        other => panic!("a type `{other}`"),
    };
    schema.iter().all(|(word, rule)| match word.as_str() {
        "$schema" | "title" | "description" | "default" => true,
        "type" => match rule {
            Value::String(word) => is(word),
            words => words
                .as_array()
                .expect("types")
                .iter()
                .any(|word| is(word.as_str().expect("a type"))),
        },
        "enum" => rule.as_array().expect("values").contains(value),
        "const" => rule == value,
        "prefixItems" => value.as_array().is_none_or(|items| {
            let rules = rule.as_array().expect("schemas").iter();
            rules.zip(items).all(|(rule, item)| fits(rule, item))
        }),
        "minItems" | "maxItems" => value.as_array().is_none_or(|items| {
            let count = rule.as_u64().expect("a count");
            let many = items.len() as u64;
            many == count || (many < count) == (word == "maxItems")
        }),
        "minimum" => value
            .as_f64()
            .is_none_or(|number| number >= rule.as_f64().expect("a number")),
        "pattern" => value
            .as_str()
            .is_none_or(|text| pattern(rule.as_str().expect("a pattern"), text)),
        "anyOf" => rule
            .as_array()
            .expect("schemas")
            .iter()
            .any(|schema| fits(schema, value)),
        "items" => value
            .as_array()
            .is_none_or(|items| items.iter().all(|item| fits(rule, item))),
        "required" => value.as_object().is_none_or(|object| {
            let names = rule.as_array().expect("names").iter();
            names
                .map(|name| name.as_str().expect("a name"))
                .all(|name| object.contains_key(name))
        }),
        "properties" => value.as_object().is_none_or(|object| {
            let rules = rule.as_object().expect("properties").iter();
            rules
                .filter_map(|(name, rule)| Some((rule, object.get(name)?)))
                .all(|(rule, value)| fits(rule, value))
        }),
        "patternProperties" => value.as_object().is_none_or(|object| {
            let (name, rule) = rule
                .as_object()
                .expect("patterns")
                .iter()
                .next()
                .expect("one");
            object
                .iter()
                .all(|(key, value)| !pattern(name, key) || fits(rule, value))
        }),
        "additionalProperties" => value.as_object().is_none_or(|object| {
            let others = schema.get("patternProperties").and_then(Value::as_object);
            let others = others.and_then(|of| of.keys().next());
            let is_other =
                |key: &str| !known(key) && !others.is_some_and(|name| pattern(name, key));
            object
                .iter()
                .filter(|(key, _)| is_other(key))
                .all(|(_, value)| match rule {
                    Value::Bool(allowed) => *allowed,
                    schema => fits(schema, value),
                })
        }),
        other => panic!("a word `{other}`"),
    })
}

fn json(text: &str) -> Value {
    let table: toml::Table = toml::from_str(text).expect("TOML");
    serde_json::to_value(table).expect("no dates")
}

fn scenes() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let files = fs::read_dir(folder).expect("the gallery");
    let files = files.map(|entry| entry.expect("an entry").path());
    // Folders hold the files that scenes name.
    let gallery = files
        .filter(|path| path.is_file())
        .map(|path| fs::read_to_string(path).expect("a scene"));
    let gallery: Vec<String> = gallery.collect();
    assert!(gallery.len() > 10);
    let others = SCENES_FOR_FAULTS.map(|(text, _)| text.to_owned());
    gallery.into_iter().chain(others).collect()
}

#[test]
fn every_scene_fits_the_schema() {
    let registry = Registry::with_builtin();
    let schema = json_schema(&registry);
    for text in scenes() {
        SceneDocument::parse("scene.toml", &text, &registry).expect("a scene");
        assert!(fits(&schema, &json(&text)), "{text}");
    }
}

/// Each fault of each key is refused by the schema, as it is by the reader; the same scene without it fits where the reader
/// takes it.
#[test]
fn every_fault_is_one_of_the_schema() {
    let registry = Registry::with_builtin();
    let schema = json_schema(&registry);
    let (mut refused, mut taken) = (0, 0);
    // JSON has no number that is not finite.
    let is_of_json = |fault: &Fault| {
        let number = fault.written.parse::<f64>();
        !number.is_ok_and(|number| !number.is_finite())
    };
    for fault in faults(&registry).into_iter().filter(is_of_json) {
        for (scene, name) in SCENES_FOR_FAULTS {
            let (text, _) = fault.within(scene, name);
            assert!(!fits(&schema, &json(&text)), "{text}");
            refused += 1;
            let (text, _) = fault.mended(scene, name);
            if SceneDocument::parse("scene.toml", &text, &registry).is_ok() {
                assert!(fits(&schema, &json(&text)), "{text}");
                taken += 1;
            }
        }
    }
    assert!(taken > 100 && refused > taken, "{refused}, {taken}");
}

/// The paths of a value's parts, those within the parameters of parts left out: a part may ask for truth values.
fn paths(value: &Value, path: &[String], all: &mut Vec<Vec<String>>) {
    let Some(object) = value.as_object() else {
        return;
    };
    for (key, value) in object {
        let path = [path, std::slice::from_ref(key)].concat();
        all.push(path.clone());
        let is_part = path[0] == "method" && path.len() == 2;
        if !is_part {
            paths(value, &path, all);
        }
    }
}

fn at<'a>(mut table: &'a mut toml::Table, path: &[String]) -> &'a mut toml::Table {
    for key in path {
        table = table
            .get_mut(key)
            .and_then(toml::Value::as_table_mut)
            .expect("a table");
    }
    table
}

/// Each key of each scene, misspelled where the scene does not choose its name, and each value, made a truth value.
#[test]
fn what_the_schema_refuses_the_reader_refuses() {
    let registry = Registry::with_builtin();
    let schema = json_schema(&registry);
    let (mut misspelled, mut mistyped) = (0, 0);
    for text in scenes() {
        let mut all = Vec::new();
        paths(&json(&text), &[], &mut all);
        for path in all {
            let (key, before) = path.split_last().expect("a key");
            let whole: toml::Table = toml::from_str(&text).expect("TOML");
            let reads = |table: &toml::Table| {
                let text = toml::to_string(table).expect("TOML");
                SceneDocument::parse("scene.toml", &text, &registry).is_ok()
            };
            let mut wrong = whole.clone();
            at(&mut wrong, before).insert(key.clone(), true.into());
            let value = serde_json::to_value(&wrong).expect("no dates");
            assert!(
                !fits(&schema, &value) && !reads(&wrong),
                "{path:?} = true in {text}"
            );
            mistyped += 1;
            let mut wrong = whole;
            let table = at(&mut wrong, before);
            let value = table.remove(key).expect("it is there");
            table.insert(format!("{key}x"), value);
            let value = serde_json::to_value(&wrong).expect("no dates");
            if !fits(&schema, &value) {
                assert!(!reads(&wrong), "{path:?} misspelled in {text}");
                misspelled += 1;
            }
        }
    }
    assert!(
        misspelled > 100 && mistyped > misspelled,
        "{misspelled}, {mistyped}"
    );
}
