//! `leafwise plugin list`: what the search path holds, without running any of it.

use std::path::{Path, PathBuf};

use leafwise::plugins::Refusal;
use leafwise::plugins::side_file::{self, SideFile};
use serde_json::{Value, json};

use crate::arguments::{PluginArguments, PluginListArguments};
use crate::console::Console;
use crate::failure::{Failure, exit};
use crate::plugins::Parts;
use crate::table::words;

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
            console.json(&json!({ "switched_off": true, "folders": [], "plugins": [] }));
        } else {
            console.result(&format!("{}: none is looked for", Refusal::SwitchedOff));
        }
        return Ok(exit::DONE);
    }
    let folders = parts.search().folders();
    let found: Vec<(PathBuf, Result<Option<SideFile>, String>)> = parts
        .search()
        .all()
        .into_iter()
        .map(|path| {
            let side = side_file::read(&path).map_err(|refusal| refusal.to_string());
            (path, side)
        })
        .collect();
    if arguments.json {
        let list: Vec<Value> = found.iter().map(|(path, side)| entry(path, side)).collect();
        console.json(&json!({ "switched_off": false, "folders": folders, "plugins": list }));
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
    let rows: Vec<Vec<String>> = found
        .iter()
        .flat_map(|(path, side)| lines(path, side))
        .collect();
    words(&rows).iter().for_each(|line| console.result(line));
    console.result("\n`leafwise plugin check PATH` loads one and tries its parts.");
    Ok(exit::DONE)
}

fn lines(path: &Path, side: &Result<Option<SideFile>, String>) -> Vec<Vec<String>> {
    let said = match side {
        Err(problem) => problem.clone(),
        Ok(None) => "says nothing of itself without being loaded".to_owned(),
        Ok(Some(side)) => {
            let id = side.id.clone().unwrap_or_default();
            format!("{id} {}", side.version.clone().unwrap_or_default())
        }
    };
    let mut lines = vec![vec![path.display().to_string(), said.trim().to_owned()]];
    if let Ok(Some(side)) = side {
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

fn entry(path: &Path, side: &Result<Option<SideFile>, String>) -> Value {
    match side {
        Ok(side) => json!({ "path": path, "side_file": side }),
        Err(problem) => json!({ "path": path, "error": problem }),
    }
}
