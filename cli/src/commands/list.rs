//! `leafwise list`: what can be named in a scene.

use leafwise::core::Registry;
use leafwise::core::part::PartKind;
use leafwise::scene::compose::LIE_ALGEBRAS;
use serde_json::{Value, json};

use crate::arguments::{Kind, ListArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::table::words;

/// Every kind, in the order in which they are listed.
const KINDS: [(Kind, &str); 6] = [
    (Kind::Systems, "systems"),
    (Kind::Realizations, "realizations"),
    (Kind::Dynamics, "dynamics"),
    (Kind::Steppers, "steppers"),
    (Kind::Compositions, "compositions"),
    (Kind::LieAlgebras, "lie-algebras"),
];

/// Lists names with one line each; returns the exit code.
///
/// # Errors
/// Never; the signature is that of every command.
pub fn execute(arguments: &ListArguments, console: &mut Console<'_>) -> Result<u8, Failure> {
    let registry = Registry::with_builtin();
    let mut object = serde_json::Map::new();
    let mut is_first = true;
    for (kind, heading) in KINDS {
        if arguments.kind.is_some_and(|asked| asked != kind) {
            continue;
        }
        let entries = entries(kind, &registry);
        if arguments.json {
            let list: Vec<Value> = entries
                .iter()
                .map(|(name, summary)| json!({ "name": name, "summary": summary }))
                .collect();
            object.insert(heading.to_owned(), Value::Array(list));
            continue;
        }
        if entries.is_empty() && arguments.kind.is_none() {
            continue;
        }
        if !is_first {
            console.result("");
        }
        is_first = false;
        console.result(&format!("{heading}:"));
        if entries.is_empty() {
            console.result("  none in this program");
        }
        let rows: Vec<Vec<String>> = entries
            .into_iter()
            .map(|(name, text)| vec![format!("  {name}"), text])
            .collect();
        for line in words(&rows) {
            console.result(&line);
        }
    }
    if arguments.json {
        console.json(&Value::Object(object));
    } else if arguments.kind.is_none() {
        console.result("\n`leafwise describe NAME` tells more about any of them.");
    }
    Ok(exit::DONE)
}

fn entries(kind: Kind, registry: &Registry) -> Vec<(String, String)> {
    let parts = |kind: PartKind| {
        registry
            .parts()
            .into_iter()
            .filter(|info| info.kind == kind)
            .map(|info| (info.name.to_owned(), info.summary.to_owned()))
            .collect()
    };
    match kind {
        Kind::Systems => leafwise::systems::all()
            .iter()
            .map(|system| {
                let title = system.about().map(|about| about.title).unwrap_or_default();
                (system.id.to_owned(), title)
            })
            .collect(),
        Kind::Realizations => parts(PartKind::Realization),
        Kind::Dynamics => parts(PartKind::Dynamics),
        Kind::Steppers => parts(PartKind::Stepper),
        Kind::Compositions => parts(PartKind::Composition),
        Kind::LieAlgebras => LIE_ALGEBRAS
            .iter()
            .map(|algebra| (algebra.name.to_owned(), algebra.summary.to_owned()))
            .collect(),
    }
}
