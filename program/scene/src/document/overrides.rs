//! `--set path=value`: overrides applied by rewriting the scene's text.

use std::ops::Range;
use std::sync::Arc;

use toml_edit::{DocumentMut, InlineTable, Item, Key, TableLike, Value};

use super::error::SceneProblemCause;
use super::located::{Place, Source};
use super::reader::Problems;
use super::schema::{ROOT, siblings};
use super::shape::{self, Inner};
use super::suggest::nearest;
use super::system_schema::COLUMN;
use super::variables::COMPONENTS;

/// The text with all overrides applied; `None` when the text is not TOML or an override is
/// refused, which is then recorded.
pub(super) fn apply_overrides(
    text: &str,
    overrides: &[(String, String)],
    problems: &mut Problems,
) -> Option<String> {
    if overrides.is_empty() {
        return Some(text.to_owned());
    }
    let mut document = match text.parse::<DocumentMut>() {
        Ok(document) => document,
        Err(error) => {
            problems.syntax(error.message(), error.span(), (text, Source::Scene));
            return None;
        }
    };
    let mut all_applied = true;
    for (path, value) in overrides {
        if let Err((cause, span)) = apply(&mut document, path, value) {
            let given = Arc::from(format!("{path}={value}"));
            problems.push(
                cause,
                Place {
                    source: Source::Override(given),
                    span,
                },
            );
            all_applied = false;
        }
    }
    all_applied.then(|| in_layout_of(text, document.to_string()))
}

/// Rewritten text with the line ends and the byte order mark of the text it was made from, which the
/// TOML editor drops.
pub(super) fn in_layout_of(original: &str, rewritten: String) -> String {
    let lines = original.matches('\n').count();
    let mut text = if 2 * original.matches("\r\n").count() > lines {
        rewritten.replace("\r\n", "\n").replace('\n', "\r\n")
    } else {
        rewritten
    };
    if original.starts_with(BYTE_ORDER_MARK) && !text.starts_with(BYTE_ORDER_MARK) {
        text.insert(0, BYTE_ORDER_MARK);
    }
    text
}

const BYTE_ORDER_MARK: char = '\u{feff}';

type Refusal = (SceneProblemCause, Range<usize>);

/// Why a text is refused as a path.
pub(super) const NO_PATH: &str = "the path is not dotted keys such as method.epsilon";

/// Tables whose keys are no words: those of sites, `s.x[2,3]`, and of pairs, `x1,x2`.
const OF_FORMULAS: [&str; 2] = ["run.initial.", "system.bracket."];

/// The keys of a path. A key of a site or a pair needs no quotes: `run.initial.s.x[2,3]`.
pub(super) fn parse_path(path: &str) -> Option<Vec<Key>> {
    if let Ok(keys) = Key::parse(path) {
        return Some(of_component(keys));
    }
    let table = OF_FORMULAS
        .into_iter()
        .find(|table| path.starts_with(table))?;
    let key = &path[table.len()..];
    let is_plain = !key.is_empty() && !key.contains(['"', '\'', '\n']);
    let mut keys = Key::parse(table.trim_end_matches('.')).ok()?;
    keys.push(Key::new(key));
    is_plain.then_some(keys)
}

/// A component of a vector is one key: `r.x` in `run.initial.r.x`, where columns of files have keys of their own.
fn of_component(mut keys: Vec<Key>) -> Vec<Key> {
    let names: Vec<&str> = keys.iter().map(Key::get).collect();
    if let ["run", "initial", vector, component] = names[..]
        && COLUMN.iter().all(|key| key.name != component)
    {
        let key = Key::new(format!("{vector}.{component}"));
        keys.splice(2.., [key]);
    }
    keys
}

/// The place of `r.x` in the list that the scene gives for the whole vector, `r = [1, 0, 0]`, or of `s.x[3]` in that of `s[3]`.
fn entry_of_list<'t>(document: &'t mut DocumentMut, keys: &[Key]) -> Option<&'t mut Value> {
    let names: Vec<&str> = keys.iter().map(Key::get).collect();
    let ["run", "initial", key] = names[..] else {
        return None;
    };
    let (vector, rest) = key.split_once('.')?;
    let (component, site) = rest.split_at(rest.find('[').unwrap_or(rest.len()));
    let at = component_at(document, vector, component)?;
    let initial = document.get_mut("run")?.as_table_like_mut()?;
    let initial = initial.get_mut("initial")?.as_table_like_mut()?;
    if initial.contains_key(key) {
        return None;
    }
    let list = initial.get_mut(&format!("{vector}{site}"))?;
    list.as_array_mut()?.get_mut(at)
}

/// Which component of a vector of variables or of a family a name is.
fn component_at(document: &DocumentMut, vector: &str, component: &str) -> Option<usize> {
    let system = document.get("system").and_then(Item::as_table_like);
    let declared = system.and_then(|system| {
        let variables = system.get("variables").and_then(Item::as_table_like);
        let families = system.get("families").and_then(Item::as_table_like);
        let own = variables.and_then(|variables| variables.get(vector));
        own.or_else(|| {
            let family = families?.get(vector)?.as_table_like()?;
            family.get("components")
        })
    });
    let mut names = declared.and_then(Item::as_array).into_iter().flatten();
    match declared.is_some_and(Item::is_array) {
        true => names.position(|name| name.as_str() == Some(component)),
        // Declared by their number, or by a library system.
        false => COMPONENTS.iter().position(|name| *name == component),
    }
}

fn apply(document: &mut DocumentMut, path: &str, value: &str) -> Result<(), Refusal> {
    let refuse = |reason: &str| {
        let cause = SceneProblemCause::Override {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        (cause, 0..path.len())
    };
    let keys = parse_path(path).ok_or_else(|| refuse(NO_PATH))?;
    check_path(&keys, path, value)?;
    check_declared(document, &keys, path)?;
    let (_, parents) = keys
        .split_last()
        .ok_or_else(|| refuse("the path is empty"))?;
    let mut table: &mut dyn TableLike = document.as_table_mut();
    let mut reached = String::new();
    for (depth, key) in keys.iter().enumerate() {
        reached.push_str(key.get());
        for other in shape::alternatives(siblings(&reached), key.get()) {
            table.remove(other);
        }
        reached.push('.');
        if depth == parents.len() {
            break;
        }
        let item = table.entry_format(key).or_insert_with(|| match depth {
            0 => Item::Table(toml_edit::Table::new()),
            _ => Item::Value(Value::InlineTable(InlineTable::new())),
        });
        if let Some(name) = item.as_str().map(str::to_owned)
            && keys[0].get() == "method"
        {
            let mut part = InlineTable::new();
            part.insert("name", Value::from(name));
            *item = Item::Value(Value::InlineTable(part));
        }
        table = item
            .as_table_like_mut()
            .ok_or_else(|| refuse(&format!("`{}` is not a table in this scene", key.get())))?;
    }
    if is_too_large(value) {
        let most = i64::MAX;
        return Err(refuse(&format!(
            "`{value}` is larger than any whole number of TOML, at most {most}"
        )));
    }
    if is_beyond(value) {
        return Err(refuse(&format!(
            "`{value}` is beyond the largest double, 1.8e308"
        )));
    }
    write(document, &keys, value).ok_or_else(|| refuse("the path is not a table"))
}

/// Whether a value is a whole number beyond TOML's; it is not taken for a text.
fn is_too_large(value: &str) -> bool {
    let digits = value.trim().trim_start_matches(['+', '-']).replace('_', "");
    !digits.is_empty()
        && digits.chars().all(|c| c.is_ascii_digit())
        && value.trim().parse::<Value>().is_err()
        && digits.trim_start_matches('0').len() > 18
}

/// Whether a value is a decimal beyond the doubles; it is not taken for a text.
fn is_beyond(value: &str) -> bool {
    let text = value.trim().replace('_', "");
    let is_decimal = text.contains(|c: char| c.is_ascii_digit());
    is_decimal && text.parse::<f64>().is_ok_and(f64::is_infinite)
}

/// Sets the value, keeping the comment and spaces around the one it replaces.
fn write(document: &mut DocumentMut, keys: &[Key], value: &str) -> Option<()> {
    let (last, parents) = keys.split_last()?;
    let mut new: Value = value
        .trim()
        .parse()
        .unwrap_or_else(|_| Value::from(value.to_owned()));
    if let Some(entry) = entry_of_list(document, keys) {
        *new.decor_mut() = entry.decor().clone();
        *entry = new;
        return Some(());
    }
    let mut table: &mut dyn TableLike = document.as_table_mut();
    for key in parents {
        table = table.get_mut(key.get())?.as_table_like_mut()?;
    }
    match table.get_mut(last.get()) {
        Some(Item::Value(old)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        Some(Item::Table(old)) if new.is_inline_table() => {
            let mut table = Item::Value(new).into_table().ok()?;
            *table.decor_mut() = old.decor().clone();
            table.set_position(old.position());
            *old = table;
        }
        Some(item) => *item = Item::Value(new),
        None => {
            table.entry_format(last).or_insert(Item::Value(new));
        }
    }
    Some(())
}

/// Whether setting one of two keys takes the other one away, or its table.
pub(super) fn alternatives(first: &str, second: &str) -> bool {
    let holds = |table: &str, key: &str| {
        let rest = key.strip_prefix(table);
        // Parts have a name and parameters, each a key of its own.
        !table.starts_with("method.") && rest.is_some_and(|rest| rest.starts_with('.'))
    };
    if holds(first, second) || holds(second, first) {
        return true;
    }
    let parts = |path: &'_ str| -> Option<(String, String)> {
        let (table, key) = path.rsplit_once('.')?;
        Some((table.to_owned(), key.to_owned()))
    };
    let (Some((table, key)), Some((other_table, other))) = (parts(first), parts(second)) else {
        return false;
    };
    let mut removed = shape::alternatives(siblings(first), &key);
    table == other_table && removed.any(|name| name == other)
}

/// Refuses a path the scene format does not have.
pub(super) fn check_path(keys: &[Key], path: &str, value: &str) -> Result<(), Refusal> {
    let names: Vec<_> = keys.iter().map(Key::get).collect();
    let mut shape = &ROOT;
    for (depth, name) in names.iter().enumerate() {
        let cause = match shape.inner(name) {
            Inner::Known(inner) => {
                shape = inner;
                continue;
            }
            Inner::Unknown(valid) => SceneProblemCause::UnknownKey {
                key: (*name).to_owned(),
                table: match names[..depth] {
                    [] => "the scene".to_owned(),
                    [section] => format!("[{section}]"),
                    [.., table] => table.to_owned(),
                },
                nearest: nearest(name, valid.iter().copied()),
                valid: valid.into_iter().map(str::to_owned).collect(),
            },
            Inner::Keyless => SceneProblemCause::Override {
                path: path.to_owned(),
                reason: format!("`{}` has no keys", names[..depth].join(".")),
            },
        };
        return Err((cause, segment(path, name)));
    }
    let is_table = value
        .trim()
        .parse()
        .is_ok_and(|value: Value| value.is_inline_table());
    if names.len() == 1 && names[0] != "plugins" && !is_table {
        let cause = SceneProblemCause::Override {
            path: path.to_owned(),
            reason: format!(
                "`{}` is a table; name one of its keys, or give a table, {{ key = value }}",
                names[0]
            ),
        };
        return Err((cause, 0..path.len()));
    }
    Ok(())
}

/// Refuses a value for a parameter or family that the scene does not declare: it would change
/// nothing. Beside `library` the names are those of the library system, and are checked there.
fn check_declared(document: &DocumentMut, keys: &[Key], path: &str) -> Result<(), Refusal> {
    let [system, kind, name] = keys else {
        return Ok(());
    };
    let kind = match (system.get(), kind.get()) {
        ("system", "parameters") => "parameter",
        ("system", "families") => "family",
        _ => return Ok(()),
    };
    let table = document.get("system").and_then(Item::as_table_like);
    let Some(table) = table.filter(|table| !table.contains_key("library")) else {
        return Ok(());
    };
    let declared = table.get(keys[1].get()).and_then(Item::as_table_like);
    let names = declared
        .into_iter()
        .flat_map(|declared| declared.iter().map(|(name, _)| name));
    let valid: Vec<&str> = names.collect();
    if valid.contains(&name.get()) {
        return Ok(());
    }
    let cause = SceneProblemCause::unknown(kind, name.get(), valid);
    Err((cause, segment(path, name.get())))
}

fn segment(path: &str, name: &str) -> Range<usize> {
    path.find(name)
        .map_or(0..path.len(), |start| start..start + name.len())
}
