//! `leafwise list`: what can be named in a scene.

use leafwise::core::part::PartKind;
use leafwise::core::{Origin, Registry};
use leafwise::scene::compose::LIE_ALGEBRAS;
use leafwise::scene::json::object;
use serde::Serialize;

use crate::arguments::{Kind, ListArguments, PluginArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
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
pub fn execute(
    arguments: &ListArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let registry = Parts::new(plugins)?.registry;
    let mut parts = PartsJson { kinds: Vec::new() };
    let mut is_first = true;
    for (kind, heading) in KINDS {
        if arguments.kind.is_some_and(|asked| asked != kind) {
            continue;
        }
        let entries = entries(kind, &registry);
        if arguments.json {
            parts.kinds.push((heading, entries));
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
            .map(|entry| vec![format!("  {}", entry.name), entry.place(), entry.summary])
            .collect();
        for line in words(&rows) {
            console.result(&line);
        }
    }
    if arguments.json {
        console.json(&parts);
    } else if arguments.kind.is_none() {
        console.result("\n`leafwise describe NAME` shows the details of each.");
    }
    Ok(exit::DONE)
}

/// The object of `list --json`: lists by their headings.
#[derive(Serialize)]
#[serde(transparent)]
struct PartsJson {
    #[serde(serialize_with = "object")]
    kinds: Vec<(&'static str, Vec<Entry>)>,
}

/// One line of a list.
#[derive(Serialize)]
struct Entry {
    name: String,
    summary: String,
    origin: Origin,
}

impl Entry {
    /// Where it comes from, in a word or two.
    fn place(&self) -> String {
        match &self.origin {
            Origin::Library { path, version, .. } => {
                let file = path.file_name().unwrap_or(path.as_os_str());
                format!("{} {version}", file.display())
            }
            _ => "built in".to_owned(),
        }
    }
}

fn entries(kind: Kind, registry: &Registry) -> Vec<Entry> {
    let parts = |kind: PartKind| -> Vec<Entry> {
        registry
            .listing()
            .into_iter()
            .filter(|(info, _)| info.kind == kind)
            .map(|(info, origin)| Entry {
                name: info.name.to_owned(),
                summary: info.summary.to_owned(),
                origin: origin.clone(),
            })
            .collect()
    };
    let version = env!("CARGO_PKG_VERSION");
    match kind {
        Kind::Systems => {
            let mut systems = parts(PartKind::System);
            systems.sort_by_key(|system| matches!(system.origin, Origin::Library { .. }));
            systems
        }
        Kind::Realizations => parts(PartKind::Realization),
        Kind::Dynamics => parts(PartKind::Dynamics),
        Kind::Steppers => parts(PartKind::Stepper),
        Kind::Compositions => parts(PartKind::Composition),
        Kind::LieAlgebras => LIE_ALGEBRAS
            .iter()
            .map(|algebra| Entry {
                name: algebra.name.to_owned(),
                summary: algebra.summary.to_owned(),
                origin: Origin::built_in("leafwise-scene", version),
            })
            .collect(),
    }
}
