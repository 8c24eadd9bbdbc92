//! The ready scenes run to their ends, and what must not move: the bits of their numbers, the names of columns and JSON keys.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::support::{Place, gallery};

/// What every scene gave when this was written anew: `LEAFWISE_FREEZE=1 cargo test -p leafwise-cli --test program gallery`.
const FROZEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/gallery.json");

/// The whole of each scene, as a user runs it. Bits are those of every machine, so a change here is one that users see.
#[test]
fn every_scene_runs_to_its_end_with_the_bits_that_it_had() {
    let scenes = gallery();
    assert!(scenes.len() >= 30, "{} scenes", scenes.len());
    let mut found = BTreeMap::new();
    for scene in scenes {
        let text = fs::read_to_string(&scene).expect("a scene");
        let name = scene.file_stem().expect("a name").to_string_lossy();
        let mut commands = vec!["run"];
        commands.extend(text.contains("[ensemble]").then_some("ensemble"));
        commands.extend(text.contains("[sweep]").then_some("sweep"));
        for command in commands {
            found.insert(format!("{command} {name}"), frozen(command, &scene, &text));
        }
    }
    let found = serde_json::to_value(found).expect("JSON");
    if std::env::var_os("LEAFWISE_FREEZE").is_some() {
        let text = serde_json::to_string_pretty(&found).expect("text");
        fs::write(FROZEN, text + "\n").expect("a writable file");
    }
    let text = fs::read_to_string(FROZEN).expect("frozen numbers");
    let expected: Value = serde_json::from_str(&text).expect("JSON");
    let moved = moved("", &expected, &found);
    assert!(moved.is_empty(), "moved:\n{moved}");
}

/// A command's tables and keys. Scenes that run until a time take as many steps as they take.
fn frozen(command: &str, scene: &Path, text: &str) -> Value {
    let here = Place::new();
    let path = scene.to_str().expect("UTF-8");
    let said = here.leafwise(&["check", path]);
    assert_eq!(said.code, Some(0), "{path}\n{}{}", said.out, said.err);
    let said = here.leafwise(&[command, path, "--out", "out", "--json"]);
    assert_eq!(said.code, Some(0), "{command} {path}\n{}", said.err);
    let report = said.json();
    assert_eq!(report["outcome"], "done", "{command} {path}");
    let steps = text.lines().find_map(|line| {
        let (key, value) = line.split_once('=')?;
        (key.trim() == "steps").then(|| value.trim().parse::<u64>().expect("a number"))
    });
    match command {
        "ensemble" => assert_eq!(report["failed"], 0, "{path}"),
        "run" if steps.is_some() => assert_eq!(report["steps"].as_u64(), steps, "{path}"),
        _ => {}
    }
    let mut keys = Vec::new();
    list_keys(String::new(), &report, &mut keys);
    let mut tables = BTreeMap::new();
    for entry in fs::read_dir(here.path("out")).expect("a directory") {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if let Some(columns) = name
            .ends_with(".csv")
            .then(|| here.read(&format!("out/{name}")))
        {
            let digest = Sha256::digest(columns.as_bytes());
            let mut hexadecimal = String::new();
            for byte in &digest[..16] {
                write!(hexadecimal, "{byte:02x}").expect("text");
            }
            let columns = columns.lines().next().unwrap_or_default();
            tables.insert(name, json!({ "columns": columns, "digest": hexadecimal }));
        }
    }
    assert!(!tables.is_empty(), "{path}");
    json!({ "tables": tables, "keys": keys })
}

/// The paths of all keys, each once.
fn list_keys(path: String, value: &Value, keys: &mut Vec<String>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                list_keys(format!("{path}.{key}"), value, keys);
            }
        }
        Value::Array(entries) if entries.iter().any(Value::is_object) => {
            for entry in entries {
                list_keys(format!("{path}[]"), entry, keys);
            }
        }
        _ if keys.contains(&path) => {}
        _ => keys.push(path),
    }
}

/// What is not as expected, a line each.
fn moved(path: &str, expected: &Value, found: &Value) -> String {
    let (Value::Object(before), Value::Object(now)) = (expected, found) else {
        return match expected == found {
            true => String::new(),
            false => format!("{path}: {found}, was {expected}\n"),
        };
    };
    let names = before
        .keys()
        .chain(now.keys().filter(|name| !before.contains_key(*name)));
    names
        .map(|name| {
            let [before, now] =
                [before, now].map(|entries| entries.get(name).unwrap_or(&Value::Null));
            moved(&format!("{path}/{name}"), before, now)
        })
        .collect()
}
