//! Values with one fault each, made from the shape of every key.

use std::ops::Range;

use leafwise_core::part::ParameterDefault;
use leafwise_core::{PartKind, Registry};
use toml::{Table, Value};

use super::schema::{ROOT, SCENE};
use super::shape::{Key, Keys, Shape, alternatives, word_of};

/// A value of a key with one fault in it.
#[derive(Clone, Debug)]
pub struct Fault {
    /// The path of the key that the fault is in, as [`scene_keys`](super::scene_keys) has it.
    pub key: String,
    /// Table of the scene that the value is written into, where it is not the scene itself.
    table: Option<&'static str>,
    /// Name of the value.
    name: &'static str,
    /// Text of the value before the fault, and behind it.
    around: [String; 2],
    /// The fault, as TOML.
    pub written: String,
    /// Text of the same shape without a fault.
    sound: String,
}

/// Not finite, as TOML or beyond the doubles.
const NOT_FINITE: [&str; 4] = ["nan", "inf", "-inf", "1e999"];

/// Neither a word nor the name of a part.
const NO_WORD: &str = "\"no word\"";

/// An entry that no table has.
const NO_ENTRY: &str = "no-key = 1";

/// Stands for a name that the scene chooses.
const NAME: &str = "\"a name\"";

/// Stands for the value in a scene that is written anew.
const MARK: &str = "the value that has a fault";

/// Faults of every key: another kind of value, a number that is not finite or not within its bounds, an unknown word,
/// an unknown key. Parts of the registry lend their parameters.
pub fn faults(registry: &Registry) -> Vec<Fault> {
    let mut all = Vec::new();
    for key in &SCENE {
        let (whole, entries) = match &key.shape {
            Shape::Table(table) => (vec![fault(key.name, "true", "{}")], table.keys),
            shape => (of_shape([key.name; 2], shape, registry), &[][..]),
        };
        all.extend(standing(None, key.name, whole));
        for entry in entries {
            let path = format!("{}.{}", key.name, entry.name);
            let faults = of_shape([&path; 2], &entry.shape, registry);
            all.extend(standing(Some(key.name), entry.name, faults));
            // Behind the value, on a line of its own.
            let above = format!("{}\n", sound(&entry.shape));
            let unknown = fault(key.name, NO_ENTRY, "").between(&above, "");
            all.extend(standing(Some(key.name), entry.name, vec![unknown]));
        }
    }
    all
}

impl Fault {
    /// A scene with the value in the place of its own and of those that it does not stand beside: the text, and the place of
    /// the fault in it. Names that the scene chooses are `name`, a key as TOML writes it.
    ///
    /// # Panics
    /// Where the scene is no TOML, or has another value where a table should be.
    pub fn within(&self, scene: &str, name: &str) -> (String, Range<usize>) {
        self.written_into(scene, name, &self.written)
    }

    /// The same without the fault.
    ///
    /// # Panics
    /// As [`within`](Self::within).
    pub fn mended(&self, scene: &str, name: &str) -> (String, Range<usize>) {
        self.written_into(scene, name, &self.sound)
    }

    fn written_into(&self, scene: &str, name: &str, piece: &str) -> (String, Range<usize>) {
        let mut root: Table = scene.parse().expect("a scene is TOML");
        let (table, keys) = match self.table {
            None => (&mut root, ROOT.keys_with(self.name)),
            Some(table) => {
                let entry = root.entry(table).or_insert_with(|| Table::new().into());
                let entry = entry.as_table_mut().expect("a table of the scene");
                let shape = ROOT.known(table);
                (
                    entry,
                    shape.map_or(&[][..], |shape| shape.keys_with(self.name)),
                )
            }
        };
        for other in alternatives(keys, self.name) {
            table.remove(other);
        }
        table.insert(self.name.to_owned(), Value::from(MARK));
        let text = toml::to_string(&root).expect("a table is TOML");
        let mark = format!("\"{MARK}\"");
        let at = text.find(&mark).expect("a value is written");
        let [before, after] = &self.around;
        let [before, after] = [before, after].map(|text| text.replace(NAME, name));
        let start = at + before.len();
        let end = start + piece.len();
        let value = format!("{before}{piece}{after}");
        (text.replacen(&mark, &value, 1), start..end)
    }

    /// The same with more text around it.
    fn between(mut self, before: &str, after: &str) -> Self {
        self.around[0].insert_str(0, before);
        self.around[1].push_str(after);
        self
    }
}

fn fault(key: &str, written: impl Into<String>, sound: impl Into<String>) -> Fault {
    Fault {
        key: key.to_owned(),
        table: None,
        name: "",
        around: <[String; 2]>::default(),
        written: written.into(),
        sound: sound.into(),
    }
}

fn standing(
    table: Option<&'static str>,
    name: &'static str,
    faults: Vec<Fault>,
) -> impl Iterator<Item = Fault> {
    (faults.into_iter()).map(move |fault| Fault {
        table,
        name,
        ..fault
    })
}

/// Faults of a value: `key` is the last key of the path that the scene format names.
fn of_shape([key, path]: [&str; 2], shape: &Shape, registry: &Registry) -> Vec<Fault> {
    let inner = |path: &str, shape: &Shape, [before, after]: [&str; 2]| {
        let faults = of_shape([key, path], shape, registry).into_iter();
        faults
            .map(|fault| fault.between(before, after))
            .collect::<Vec<_>>()
    };
    let each = |written: &[&str]| -> Vec<Fault> {
        let sound = sound(shape);
        written
            .iter()
            .map(|written| fault(key, *written, &sound))
            .collect()
    };
    let mut all = match shape {
        Shape::Text => Vec::new(),
        Shape::Formula | Shape::Number => each(&NOT_FINITE),
        Shape::Anything => return each(&NOT_FINITE),
        Shape::Whole(least) => {
            let below = (i128::from(*least) - 1).to_string();
            [each(&NOT_FINITE), each(&[&below, "0.5"])].concat()
        }
        Shape::Words(_) | Shape::System => each(&[NO_WORD]),
        Shape::Part(kind) => [each(&[NO_WORD]), of_parameters(key, *kind, registry)].concat(),
        Shape::List(entry) => inner(path, entry, ["[", "]"]),
        Shape::Entries(entries) => {
            let mut all = Vec::new();
            for (at, entry) in entries.iter().enumerate() {
                let mut written: Vec<String> = entries.iter().map(sound).collect();
                written[at] = "\n".to_owned();
                let written = written.join(", ");
                let (left, right) = written.split_once('\n').unwrap_or_default();
                all.extend(inner(
                    path,
                    entry,
                    [&format!("[{left}"), &format!("{right}]")],
                ));
            }
            all
        }
        Shape::Names(entry) => inner(
            &format!("{path}.*"),
            entry,
            [&format!("{{ {NAME} = "), " }"],
        ),
        Shape::Pairs(entry) => inner(path, entry, ["{ \"a,b\" = ", " }"]),
        Shape::Table(table) => of_table([key, path], table, registry),
        Shape::Either(shapes) => {
            let faults = shapes
                .iter()
                .flat_map(|shape| of_shape([key, path], shape, registry));
            return faults.collect();
        }
    };
    all.extend(each(&["true"]));
    all
}

fn of_table([key, path]: [&str; 2], table: &Keys, registry: &Registry) -> Vec<Fault> {
    let mut all = Vec::new();
    let needed = beside(table, None);
    let comma = if needed.is_empty() { "" } else { ", " };
    let unknown = fault(key, format!("{NO_ENTRY}{comma}"), "");
    all.push(unknown.between("{ ", &format!("{} }}", needed.join(", "))));
    for inner in table.keys {
        let mut entries = beside(table, Some(inner));
        entries.push(format!("{} = ", inner.name));
        let before = format!("{{ {}", entries.join(", "));
        let path = format!("{path}.{}", inner.name);
        let faults = of_shape([&path; 2], &inner.shape, registry).into_iter();
        all.extend(faults.map(|fault| fault.between(&before, " }")));
    }
    all
}

/// Entries that a table needs beside a key, as TOML.
fn beside(table: &Keys, own: Option<&Key>) -> Vec<String> {
    let has_own = |set: &&&[&str]| own.is_some_and(|own| set.contains(&own.name));
    let Some(needed) = table.needs.iter().find(has_own).or(table.needs.first()) else {
        return Vec::new();
    };
    let is_beside = |key: &&Key| {
        needed.contains(&key.name)
            && own.is_none_or(|own| {
                let mut conflicts = own.conflicts().chain(key.conflicts());
                key.name != own.name
                    && !conflicts.any(|(name, _)| [own.name, key.name].contains(&name))
            })
    };
    let entries = table.keys.iter().filter(is_beside);
    entries
        .map(|key| format!("{} = {}", key.name, sound(&key.shape)))
        .collect()
}

/// Parameters of the parts that are there.
fn of_parameters(key: &str, kind: PartKind, registry: &Registry) -> Vec<Fault> {
    let parts = registry
        .parts()
        .into_iter()
        .filter(|part| part.kind == kind);
    let parameters = parts.flat_map(|part| part.parameters.iter().map(move |one| (part.name, one)));
    let faults = parameters.filter(|(_, one)| !matches!(one.default, ParameterDefault::Text(_)));
    let faults = faults.flat_map(|(part, one)| {
        let before = format!("{{ name = \"{part}\", {} = ", one.name);
        NOT_FINITE.map(|written| fault(key, written, "1").between(&before, " }"))
    });
    faults.collect()
}

/// A value of a shape, as TOML.
fn sound(shape: &Shape) -> String {
    match shape {
        Shape::Text | Shape::System => "\"a\"".to_owned(),
        Shape::Formula | Shape::Number | Shape::Anything => "1".to_owned(),
        Shape::Whole(least) => (*least).max(1).to_string(),
        Shape::Words(words) => format!("\"{}\"", words[0]),
        Shape::Part(kind) => format!("\"{}\"", word_of(*kind)),
        Shape::List(entry) => format!("[{}]", sound(entry)),
        Shape::Entries(entries) => {
            let entries: Vec<String> = entries.iter().map(sound).collect();
            format!("[{}]", entries.join(", "))
        }
        Shape::Names(entry) => format!("{{ {NAME} = {} }}", sound(entry)),
        Shape::Pairs(entry) => format!("{{ \"a,b\" = {} }}", sound(entry)),
        Shape::Table(table) => format!("{{ {} }}", beside(table, None).join(", ")),
        Shape::Either(shapes) => sound(&shapes[0]),
    }
}
