//! `plugins = ["…"]`: shared libraries whose parts a scene uses.

use super::located::Located;
use super::overrides::apply_overrides;
use super::reader::{Item, Problems, Table, end_of};
use super::schema::PLUGIN;
use toml::de::DeTable;

/// A shared library to load before the scene is composed.
#[derive(Clone, Debug, PartialEq)]
pub struct PluginSpec {
    /// A path, relative to the scene's folder, or a name to search for.
    pub path: Located<String>,
    /// The SHA-256 that the file must have, in hexadecimal.
    pub sha256: Option<Located<String>>,
}

impl PluginSpec {
    /// Text after overrides, and the plugins that it names. The rest of the text is not read, since it may be about the
    /// plugins' parts. The list is empty where the text is so wrong that only parsing the whole of it can tell.
    pub fn of_scene(text: &str, overrides: &[(String, String)]) -> (String, Vec<Self>) {
        let mut problems = Problems::default();
        let Some(text) = apply_overrides(text, overrides, &mut problems) else {
            return (text.to_owned(), Vec::new());
        };
        let plugins = DeTable::parse(&text).ok().and_then(|document| {
            let root = Table::new("the scene", document.get_ref(), end_of(&text), &text);
            read_plugins(&root, &mut problems)
        });
        let plugins = plugins.unwrap_or_default();
        (text, plugins)
    }
}

/// Reads `plugins`, a list of paths or tables.
pub(super) fn read_plugins(root: &Table<'_>, problems: &mut Problems) -> Option<Vec<PluginSpec>> {
    match root.get("plugins") {
        Some(item) => item.list_of("a list of paths", problems, read_plugin),
        None => Some(Vec::new()),
    }
}

fn read_plugin(item: &Item<'_>, problems: &mut Problems) -> Option<PluginSpec> {
    if item.is_string() {
        return Some(PluginSpec {
            path: item.string(problems)?,
            sha256: None,
        });
    }
    let table = item.table(&item.title, "a path or a table { path = \"…\" }", problems)?;
    table.only(&PLUGIN, problems);
    let path = table
        .require("path", "{ path = \"./libacme.so\" }", problems)
        .and_then(|path| path.string(problems));
    let sha256 = match table.get("sha256") {
        Some(hash) => Some(hash.string(problems)?),
        None => None,
    };
    Some(PluginSpec {
        path: path?,
        sha256,
    })
}
