//! The modules of a crate import from one another in one direction.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::sources::{code, sources};

/// A module's path within its crate; the root is empty.
type Module = Vec<String>;

/// What a module imports: whether it exports it again, and the path as it is written.
struct Import {
    is_public: bool,
    path: Vec<String>,
}

fn module_of(source: &Path) -> Module {
    let mut parts: Module = source
        .with_extension("")
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if parts
        .last()
        .is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str()))
    {
        parts.pop();
    }
    parts
}

/// Words, `::`, and other signs by themselves.
fn tokens(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = match first {
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            ':' if rest.starts_with("::") => 2,
            c => c.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        if !token.trim().is_empty() {
            found.push(token);
        }
        rest = after;
    }
    found
}

/// The paths of a use tree, up to the end of its statement or group.
fn tree(tokens: &mut std::slice::Iter<'_, &str>, prefix: &[String], found: &mut Vec<Vec<String>>) {
    let mut path = prefix.to_vec();
    let mut is_renamed = false;
    while let Some(&token) = tokens.next() {
        match token {
            ";" | "}" | "," => {
                if path.len() > prefix.len() {
                    found.push(std::mem::replace(&mut path, prefix.to_vec()));
                }
                is_renamed = false;
                if token != "," {
                    return;
                }
            }
            "{" => {
                tree(tokens, &path, found);
                path = prefix.to_vec();
            }
            "::" => {}
            "as" => is_renamed = true,
            word if !is_renamed => path.push(word.to_owned()),
            _ => {}
        }
    }
}

/// The statements `use …;` of a source, and the paths in it that begin with crate, super or self.
fn imports(text: &str) -> Vec<Import> {
    let tokens = tokens(text);
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let before = if at > 0 { tokens[at - 1] } else { ";" };
        if tokens[at] == "use" {
            let opens = tokens[..at].iter().rposition(|token| *token == "(");
            let is_public = match before {
                ")" => opens.is_some_and(|opens| opens > 0 && tokens[opens - 1] == "pub"),
                other => other == "pub",
            };
            let mut rest = tokens[at + 1..].iter();
            let mut paths = Vec::new();
            tree(&mut rest, &[], &mut paths);
            found.extend(paths.into_iter().map(|path| Import { is_public, path }));
            at = tokens.len() - rest.len();
            continue;
        }
        let is_path = ["crate", "super", "self"].contains(&tokens[at]) && before != "::";
        if is_path && tokens.get(at + 1) == Some(&"::") {
            let words = tokens[at..]
                .chunks(2)
                .take_while(|pair| pair.get(1) == Some(&"::"));
            let length = words.count();
            let path = tokens[at..].iter().step_by(2).take(length + 1);
            found.push(Import {
                is_public: false,
                path: path.map(|word| (*word).to_owned()).collect(),
            });
        }
        at += 1;
    }
    found
}

/// A crate's modules with what they import.
struct Crate {
    imports: BTreeMap<Module, Vec<Import>>,
    /// What a module exports of others: where that stands.
    exported: BTreeMap<(Module, String), (Module, Vec<String>)>,
}

impl Crate {
    fn read(folder: &Path) -> Self {
        let mut files = Vec::new();
        sources(folder, &mut files);
        let mut read = Self {
            imports: BTreeMap::new(),
            exported: BTreeMap::new(),
        };
        for file in files {
            let relative = file.strip_prefix(folder).expect("a file of the folder");
            if relative.starts_with("bin") {
                continue;
            }
            let text = fs::read_to_string(&file).expect("a source");
            let lines: Vec<&str> = code(&text).map(|(_, line)| line).collect();
            read.imports
                .insert(module_of(relative), imports(&lines.join("\n")));
        }
        for (home, imports) in &read.imports {
            for import in imports.iter().filter(|import| import.is_public) {
                if let (Some(found), Some(name)) =
                    (read.resolve(home, &import.path), import.path.last())
                {
                    read.exported.insert((home.clone(), name.clone()), found);
                }
            }
        }
        read
    }

    /// The module that a path from `home` leads into, and the rest of the path; `None` of another crate.
    fn resolve(&self, home: &Module, path: &[String]) -> Option<(Module, Vec<String>)> {
        let child = || [&home[..], &path[..1]].concat();
        let supers = path.iter().take_while(|word| *word == "super").count();
        let whole = match path[0].as_str() {
            "crate" => path[1..].to_vec(),
            "self" => [&home[..], &path[1..]].concat(),
            "super" => [&home[..home.len().saturating_sub(supers)], &path[supers..]].concat(),
            _ if self.imports.contains_key(&child()) => [&home[..], path].concat(),
            _ => return None,
        };
        let length = (0..=whole.len())
            .rev()
            .find(|length| self.imports.contains_key(&whole[..*length]))?;
        Some((whole[..length].to_vec(), whole[length..].to_vec()))
    }

    /// The modules where what `home` imports is written down, exports of its own submodules left out.
    fn imported_by(&self, home: &Module) -> BTreeSet<Module> {
        let mut found = BTreeSet::new();
        for Import { is_public, path } in &self.imports[home] {
            let Some((mut target, mut rest)) = self.resolve(home, path) else {
                continue;
            };
            let mut seen = BTreeSet::new();
            while let Some(next) = rest
                .first()
                .and_then(|name| self.exported.get(&(target.clone(), name.clone())))
                && seen.insert(target.clone())
            {
                (target, rest) = next.clone();
            }
            let is_own = *is_public && target.len() > home.len();
            if target != *home && !is_own {
                found.insert(target);
            }
        }
        found
    }

    /// A module that imports itself by way of others.
    fn cycle(&self) -> Option<Vec<String>> {
        let edges: BTreeMap<&Module, BTreeSet<Module>> = self
            .imports
            .keys()
            .map(|home| (home, self.imported_by(home)))
            .collect();
        let on_a_cycle = |home: &&Module| {
            let (mut reached, mut open) = (BTreeSet::new(), vec![(*home).clone()]);
            while let Some(module) = open.pop() {
                for next in &edges[&module] {
                    if reached.insert(next.clone()) {
                        open.push(next.clone());
                    }
                }
            }
            reached.contains(*home)
        };
        let members: Vec<String> = self
            .imports
            .keys()
            .filter(on_a_cycle)
            .map(|m| m.join("::"))
            .collect();
        (!members.is_empty()).then_some(members)
    }
}

/// The folders `src` of the workspace.
fn crates(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry of a folder").path();
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        match name.as_deref() {
            _ if !path.is_dir() => {}
            Some("src") => found.push(path),
            Some(name) if name == "target" || name.starts_with('.') => {}
            _ => crates(&path, found),
        }
    }
}

#[test]
fn modules_import_in_one_direction() {
    let mut folders = Vec::new();
    crates(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join(".."),
        &mut folders,
    );
    assert!(folders.len() > 20, "{folders:?}");
    let found: Vec<_> = folders
        .iter()
        .filter_map(|folder| Some((folder.display().to_string(), Crate::read(folder).cycle()?)))
        .collect();
    assert!(
        found.is_empty(),
        "modules that import one another: {found:#?}"
    );
}

/// Three modules: a → b by name, b → c by what the root exports, c → a by a path in its code.
#[test]
fn a_cycle_through_an_export_and_a_path_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write(
        "lib.rs",
        "mod a;\nmod b;\nmod c;\npub use c::{Deep, Other as Another};\n",
    );
    write("a.rs", "use crate::b::{self, B};\n");
    write("b.rs", "use super::Deep;\n");
    write("c.rs", "pub struct Deep;\n");
    assert_eq!(Crate::read(folder.path()).cycle(), None);
    write(
        "c.rs",
        "pub struct Deep;\nfn f() -> crate::a::A { todo!() }\n// use crate::b::B;\n",
    );
    let members = ["a", "b", "c"].map(str::to_owned).to_vec();
    assert_eq!(Crate::read(folder.path()).cycle(), Some(members));
}
