//! What others need to know of a part, the part says: no source but its own names it.

use std::fs;
use std::path::Path;

use leafwise::core::{PartKind, Registry};

use crate::sources::{code, sources};

/// Sources that serve every part alike. The figures of the paper (`reproduce`) and the cases of `stress`
/// choose their methods as scenes do.
const ROOMS: [&str; 13] = [
    "expression/src",
    "solver/src",
    "core/src",
    "systems/src",
    "program/scene/src",
    "program/report/src",
    "program/run/src",
    "program/studies/src",
    "program/cli/src",
    "leafwise/src",
    "plugins/abi/src",
    "plugins/sdk/src",
    "plugins/loader/src",
];
const CASES: [&str; 2] = [
    "program/studies/src/reproduce",
    "program/studies/src/stress",
];

/// Words that are names of parts too, and examples in messages.
const OTHER_MEANINGS: [(&str, &str); 11] = [
    ("program/scene/src/document/bracket.rs", "one-form"),
    ("program/scene/src/document/system_schema.rs", "one-form"),
    ("program/scene/src/compose/shape.rs", "constant"),
    (
        "program/scene/src/document/system_schema.rs",
        "log-canonical",
    ),
    (
        "program/scene/src/document/system_checks.rs",
        "log-canonical",
    ),
    ("program/scene/src/document/method.rs", "karasev-truncated"),
    ("program/scene/src/document/method.rs", "hamilton-jacobi"),
    ("program/scene/src/document/method.rs", "implicit-midpoint"),
    ("plugins/loader/src/smoke/problems.rs", "log-canonical"),
    ("program/run/src/advice/step.rs", "dop853"),
    ("program/run/src/advice/step.rs", "taylor"),
];

#[test]
fn no_source_names_a_part_but_its_own() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let registry = Registry::with_builtin();
    let parts = registry.parts().into_iter();
    let names: Vec<&str> = parts
        .filter(|info| info.kind != PartKind::System)
        .map(|info| info.name)
        .collect();
    assert!(
        names.len() >= 30,
        "every crate of parts is linked: {names:?}"
    );
    let mut files = Vec::new();
    for room in ROOMS {
        sources(&root.join(room), &mut files);
    }
    let mut found = Vec::new();
    for file in files {
        let place = file.strip_prefix(&root).expect("below the root");
        let place = place.to_str().expect("a name in UTF-8").replace('\\', "/");
        if CASES.iter().any(|folder| place.starts_with(folder)) {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file:?}: {error}"));
        for (at, line) in code(&text) {
            for name in &names {
                let is_named = line.contains(&format!("\"{name}\""));
                if is_named && !OTHER_MEANINGS.contains(&(place.as_str(), *name)) {
                    found.push(format!("{place}:{}: {name}", at + 1));
                }
            }
        }
    }
    assert!(found.is_empty(), "names of parts:\n{}", found.join("\n"));
}
