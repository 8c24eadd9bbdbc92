//! The keys of scenes as tables, for the guide.

use std::fmt::Write as _;

use super::families::DENSE_LIMIT;
use super::schema::{ROOT, each_key};
use super::shape::{Beside, Default, Key, Keys, Shape, alternatives};

/// Every key of a scene as a page of Markdown: a table for each of the scene's tables.
pub fn key_tables() -> String {
    let mut sections = Vec::new();
    collect("", &ROOT, &mut sections);
    let mut page = format!(
        "# Keys of scenes\n\n\
         Keys of a scene, each with its kind, its default, and the keys that exclude it. `leafwise schema --markdown` prints \
         this page.\n\n\
         A key is set from outside by its path, as `--set run.record.every=10`. In a path `NAME` is a name that the scene \
         chooses. A number serves as a formula too. A long lattice has more than {DENSE_LIMIT} coordinates in its families. With `library`, keys that \
         are left out are those of the library's system.\n"
    );
    for section in &sections {
        section.write(&sections, &mut page);
    }
    page
}

/// The keys that stand at a path, in one table or in one of several.
struct Section {
    path: String,
    tables: Vec<&'static Keys>,
}

/// Collects the tables of a shape, each where it is met first.
fn collect(path: &str, shape: &'static Shape, sections: &mut Vec<Section>) {
    match shape {
        Shape::Table(table) => {
            if place_of(table, sections).is_some() {
                return;
            }
            match sections.iter_mut().find(|section| section.path == path) {
                Some(section) => section.tables.push(table),
                None => sections.push(Section {
                    path: path.to_owned(),
                    tables: vec![table],
                }),
            }
            for key in table.keys {
                collect(&path_of(path, key.name), &key.shape, sections);
            }
        }
        Shape::List(each) => collect(path, each, sections),
        Shape::Names(each) | Shape::Pairs(each) => collect(&path_of(path, "NAME"), each, sections),
        Shape::Either(shapes) => {
            for shape in *shapes {
                collect(path, shape, sections);
            }
        }
        _ => {}
    }
}

fn path_of(table: &str, name: &str) -> String {
    match table {
        "" => name.to_owned(),
        table => format!("{table}.{name}"),
    }
}

/// The section that shows a table.
fn place_of<'s>(table: &Keys, sections: &'s [Section]) -> Option<&'s Section> {
    let is_shown = |section: &&Section| {
        let mut tables = section.tables.iter();
        tables.any(|shown| std::ptr::eq(shown.keys, table.keys))
    };
    sections.iter().find(is_shown)
}

impl Section {
    fn write(&self, sections: &[Section], page: &mut String) {
        let title = self.title();
        let level = match self.path.contains('.') {
            true => "###",
            false => "##",
        };
        let needs = needs(&self.tables);
        let mut line = |text: &str| writeln!(page, "{text}").expect("a string takes any text");
        line(&format!("\n{level} {title}\n"));
        if !needs.is_empty() {
            line(&format!("Needs {needs}.\n"));
        }
        line("| Key | Value | Default | Meaning | Excluded by |");
        line("|---|---|---|---|---|");
        for table in &self.tables {
            for key in table.keys {
                let path = path_of(&self.path, key.name);
                line(&format!(
                    "| `{}` | {} | {} | {} | {} |",
                    key.name,
                    value(&key.shape, sections),
                    default(key),
                    plain(key.about),
                    not_beside(&path, key, table.keys),
                ));
            }
        }
    }

    /// The heading.
    fn title(&self) -> String {
        match self.path.as_str() {
            "" => "The scene".to_owned(),
            path if path.contains('.') || path == "plugins" => format!("`{path}`"),
            path => format!("`[{path}]`"),
        }
    }

    /// The anchor of the heading.
    fn anchor(&self) -> String {
        let kept = self
            .path
            .chars()
            .filter(|c| c.is_alphanumeric() || *c == '-');
        kept.collect::<String>().to_lowercase()
    }
}

/// The sets of keys of which one has to be there whole.
fn needs(tables: &[&'static Keys]) -> String {
    let sets: Vec<&[&str]> = tables
        .iter()
        .flat_map(|table| table.needs)
        .copied()
        .collect();
    let are_single = sets.len() > 1 && sets.iter().all(|set| set.len() == 1);
    let written: Vec<String> = (sets.iter())
        .map(|set| {
            let names: Vec<String> = set.iter().map(|name| format!("`{name}`")).collect();
            listed(&names, "and")
        })
        .collect();
    match are_single {
        true => format!("one of {}", written.join(", ")),
        false => written.join(", or "),
    }
}

/// Entries with a word before the last.
fn listed(entries: &[String], word: &str) -> String {
    match entries {
        [first @ .., last] if !first.is_empty() => format!("{} {word} {last}", first.join(", ")),
        all => all.join(", "),
    }
}

/// A shape in words.
fn value(shape: &Shape, sections: &[Section]) -> String {
    let nested = |shape: &Shape| value(shape, sections).replace("; or ", " or ");
    match shape {
        Shape::Text => "text".to_owned(),
        Shape::Formula => "formula".to_owned(),
        Shape::Number => "number".to_owned(),
        Shape::Whole(least) => format!("whole number from {least}"),
        Shape::Anything => "any value".to_owned(),
        Shape::Words(words) => {
            let words: Vec<String> = words.iter().map(|word| format!("`\"{word}\"`")).collect();
            listed(&words, "or")
        }
        Shape::List(each) => match each {
            Shape::Text => "list of texts".to_owned(),
            Shape::Formula => "list of formulas".to_owned(),
            Shape::Number => "list of numbers".to_owned(),
            each => format!("list, each {}", nested(each)),
        },
        Shape::Entries(entries) => {
            let entries: Vec<String> = entries.iter().map(nested).collect();
            format!("list of {} entries: {}", entries.len(), entries.join(", "))
        }
        Shape::Table(table) => match place_of(table, sections) {
            Some(section) => format!("[table](#{})", section.anchor()),
            None => "table".to_owned(),
        },
        Shape::Names(each) => format!("by names, each {}", nested(each)),
        Shape::Pairs(each) => format!("by pairs `\"x,y\"`, each {}", nested(each)),
        Shape::Either(shapes) => {
            let mut shapes: Vec<String> = shapes.iter().map(nested).collect();
            shapes.dedup();
            shapes.join("; or ")
        }
        Shape::Part(kind) => format!(
            "name of a {}, or `{{ name = \"…\" }}` with its parameters",
            kind.noun()
        ),
        Shape::System => "name of a system".to_owned(),
    }
}

fn default(key: &Key) -> String {
    match key.default {
        None => String::new(),
        Some(Default::Toml(written)) => format!("`{written}`"),
        Some(Default::Words(words)) => words.to_owned(),
    }
}

/// Everything that a key of a table does not stand beside: as it says itself, and as others say of it.
fn not_beside(path: &str, key: &Key, siblings: &'static [Key]) -> String {
    let mut names: Vec<String> = alternatives(siblings, key.name)
        .map(str::to_owned)
        .collect();
    let mut others = Vec::new();
    for beside in key.beside {
        match beside {
            Beside::InPlaceOf { .. } => {}
            Beside::Keys { keys, .. } => names.extend(keys.iter().map(|name| (*name).to_owned())),
            Beside::Elsewhere { paths, .. } => {
                names.extend(paths.iter().map(|path| (*path).to_owned()));
            }
            Beside::Without { path, .. } => others.push(format!("a scene without `{path}`")),
            Beside::Note(note) => others.push((*note).to_owned()),
        }
    }
    let refuses = |other: &&Key| {
        let mut beside = other.beside.iter();
        beside.any(|beside| matches!(beside, Beside::Keys { keys, .. } if keys.contains(&key.name)))
    };
    names.extend(
        siblings
            .iter()
            .filter(refuses)
            .map(|other| other.name.to_owned()),
    );
    for (other, declared) in each_key() {
        let mut beside = declared.beside.iter();
        if beside.any(
            |beside| matches!(beside, Beside::Elsewhere { paths, .. } if paths.contains(&path)),
        ) {
            names.push(other);
        }
    }
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    let names = Some(names.join(", ")).filter(|names| !names.is_empty());
    names
        .into_iter()
        .chain(others)
        .collect::<Vec<_>>()
        .join("; ")
}

/// A text without signs of Markdown, but for those between backquotes.
fn plain(text: &str) -> String {
    let mut is_code = false;
    let mut plain = String::with_capacity(text.len());
    for sign in text.chars() {
        is_code ^= sign == '`';
        if sign == '|' || !is_code && ['*', '<', '[', ']', '_'].contains(&sign) {
            plain.push('\\');
        }
        plain.push(sign);
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compose::WIDEST_STATE;

    #[test]
    fn a_key_is_needed_or_has_a_default() {
        let mut sections = Vec::new();
        collect("", &ROOT, &mut sections);
        for section in &sections {
            let needed: Vec<&str> = (section.tables.iter())
                .flat_map(|table| table.needs.iter().copied().flatten().copied())
                .collect();
            for key in section.tables.iter().flat_map(|table| table.keys) {
                let place = path_of(&section.path, key.name);
                assert_ne!(needed.contains(&key.name), key.default.is_some(), "{place}");
            }
        }
    }

    #[test]
    fn every_key_has_a_row_with_what_it_does_not_stand_beside() {
        let page = key_tables();
        let row = |section: &str, key: &str| {
            let (_, rest) = page
                .split_once(&format!(" {section}\n"))
                .expect("a section");
            let start = format!("| `{key}` |");
            let row = rest.lines().find(|line| line.starts_with(&start));
            row.expect("a row").to_owned()
        };
        for (path, key) in each_key() {
            assert!(page.contains(&format!("\n| `{}` |", key.name)), "{path}");
        }
        assert!(row("`[method]`", "epsilon").ends_with("| `time-step` |"));
        assert!(row("`[run]`", "stop").ends_with("| `system.noise` |"));
        assert!(row("`[system]`", "forces").contains("`method.pace`"));
        assert!(row("`[system]`", "hamiltonian").ends_with("| `library`, `equations` |"));
        assert!(row("`run.record`", "interval").contains("a scene without `method.pace`"));
        assert!(row("`run.record`", "states").contains(&format!(" {WIDEST_STATE} coordinates")));
    }
}
