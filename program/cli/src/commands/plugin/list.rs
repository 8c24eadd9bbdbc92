//! `leafwise plugin list`: what the search path holds, without running any of it.

use std::path::PathBuf;

use leafwise::plugins::Refusal;
use leafwise::plugins::side_file::{self, SideFile};
use serde::Serialize;

use crate::arguments::{PluginArguments, PluginListArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

/// The object of `plugin list --json`.
#[derive(Default, Serialize)]
struct PluginsJson {
    switched_off: bool,
    folders: Vec<PathBuf>,
    plugins: Vec<Entry>,
}

/// A library with what the file beside it says.
#[derive(Serialize)]
struct Entry {
    path: PathBuf,
    #[serde(flatten)]
    said: Said,
}

/// Content of the file beside a library, or the reason why it cannot be read.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Said {
    SideFile(Option<SideFile>),
    Error(String),
}

/// Lists the libraries of the search path with what the files beside them say; returns the exit code.
///
/// # Errors
/// [`Failure::Plugin`] for a plugin of the command line.
pub fn execute(
    arguments: &PluginListArguments,
    plugins: &PluginArguments,
    console: &mut Console<'_>,
) -> Result<u8, Failure> {
    let parts = Parts::new(plugins)?;
    if parts.are_off() {
        if arguments.json {
            console.json(&PluginsJson {
                switched_off: true,
                ..PluginsJson::default()
            });
        } else {
            console.result(&format!("{}: none is looked for", Refusal::SwitchedOff));
        }
        return Ok(exit::DONE);
    }
    let folders = parts.search().folders();
    let found = parts.search().all().into_iter().map(|path| {
        let said = match side_file::read(&path) {
            Ok(side_file) => Said::SideFile(side_file),
            Err(refusal) => Said::Error(refusal.to_string()),
        };
        Entry { path, said }
    });
    let found: Vec<Entry> = found.collect();
    if arguments.json {
        console.json(&PluginsJson {
            switched_off: false,
            folders: folders.to_vec(),
            plugins: found,
        });
        return Ok(exit::DONE);
    }
    if found.is_empty() {
        console.result("no plugin is in the folders of the search path:");
        let shown = folders
            .iter()
            .map(|folder| format!("  {}", folder.display()));
        shown.for_each(|line| console.result(&line));
        console.result("a plugin elsewhere is named by its path, in a scene or with --plugin");
        return Ok(exit::DONE);
    }
    let rows: Vec<Vec<String>> = found.iter().flat_map(lines).collect();
    words(&rows).iter().for_each(|line| console.result(line));
    console.result("\n`leafwise plugin check PATH` loads one and tries its parts.");
    Ok(exit::DONE)
}

fn lines(entry: &Entry) -> Vec<Vec<String>> {
    let said = match &entry.said {
        Said::Error(problem) => problem.clone(),
        Said::SideFile(None) => "has no description until it is loaded".to_owned(),
        Said::SideFile(Some(side)) => {
            let id = side.id.clone().unwrap_or_default();
            format!("{id} {}", side.version.clone().unwrap_or_default())
        }
    };
    let mut lines = vec![vec![
        entry.path.display().to_string(),
        said.trim().to_owned(),
    ]];
    if let Said::SideFile(Some(side)) = &entry.said {
        lines.extend(side.parts.iter().map(|part| {
            let summary = part.summary.clone().unwrap_or_default();
            vec![
                format!("  {}", part.id),
                format!("{}: {summary}", part.kind),
            ]
        }));
    }
    lines
}
