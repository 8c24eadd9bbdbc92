//! The `[sweep]` table: one run for each of many settings of the scene's keys.

use toml_edit::Key;

use super::error::SceneProblemCause;
use super::located::{Located, Place};
use super::observable::ObservableSpec;
use super::overrides::{NO_PATH, alternatives, check_path, parse_path};
use super::reader::{Item, Problems, Table};
use super::run::read_observables;
use super::schema::{GRID_RANGES, SWEEP, SWEEP_RECORD};
use super::system_section::SystemSection;

/// The `[sweep]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepSection {
    /// The table's header.
    pub place: Place,
    /// The settings.
    pub settings: SettingsSpec,
    /// Observables measured of each last state.
    pub observables: Vec<ObservableSpec>,
    /// The run directory, when the scene names one.
    pub out: Option<Located<String>>,
}

/// A key as `--set` has it.
pub type SweptKey = Located<String>;

/// A key with all its values.
pub type SweptDirection = (SweptKey, Vec<Located<String>>);

/// Keys with a value each.
pub type SweptRow = Vec<(SweptKey, Located<String>)>;

/// Where settings come from. Values are TOML.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingsSpec {
    /// All combinations of the keys' values; those of the last key follow one another.
    Grid(Vec<SweptDirection>),
    /// Values given together, row by row.
    List(Vec<SweptRow>),
    /// The rows of a CSV file beside the scene, whose first row names the keys.
    File(Located<String>),
}

/// The most settings.
pub const MOST_SETTINGS: u64 = 1_000_000;

/// Keys that the runs of a sweep share, and what to do instead.
const SHARED: [(&str, &str); 5] = [
    ("sweep", "a sweep has no sweep in it"),
    (
        "ensemble",
        "the settings of a sweep are single runs: vary parameters and states of members in [ensemble]",
    ),
    (
        "plugins",
        "all settings share their plugins: name all of them in the scene",
    ),
    (
        "run.record",
        "all settings have the same columns: write them into record of [sweep]",
    ),
    ("run.out", "a sweep is one table: write `out` into [sweep]"),
];

/// Reads `[sweep]`; `system` has the default observables.
pub(super) fn read_sweep(
    table: &Table<'_>,
    system: Option<&SystemSection>,
    problems: &mut Problems,
) -> Option<SweepSection> {
    table.only(&SWEEP, problems);
    let settings = read_settings(table, problems);
    let observables = match table.get("record") {
        None => read_observables(None, &table.place, system, problems),
        Some(item) => item
            .table("record", "a table", problems)
            .and_then(|record| {
                record.only(&SWEEP_RECORD, problems);
                read_observables(Some(&record), &table.place, system, problems)
            }),
    };
    let out = match table.get("out") {
        Some(item) => item.string(problems).map(Some),
        None => Some(None),
    };
    Some(SweepSection {
        place: table.place.clone(),
        settings: settings?,
        observables: observables?,
        out: out?,
    })
}

fn read_settings(table: &Table<'_>, problems: &mut Problems) -> Option<SettingsSpec> {
    if !table.has_choice(&SWEEP) {
        let example = "grid = { \"method.time-step\" = [0.05, 0.1, 0.2] }, list = [{ … }, { … }] or file = \"settings.csv\"";
        table.require("grid", example, problems);
    }
    let first = table.choice(&SWEEP)?;
    match first.key.value.as_str() {
        "grid" => read_grid(first, problems).map(SettingsSpec::Grid),
        "list" => read_list(first, problems).map(SettingsSpec::List),
        _ => first.string(problems).map(SettingsSpec::File),
    }
}

fn read_grid(item: &Item<'_>, problems: &mut Problems) -> Option<Vec<SweptDirection>> {
    let grid = item.table("grid", "a table of keys with their values", problems)?;
    let mut directions = Some(Vec::with_capacity(grid.items.len()));
    for entry in &grid.items {
        let values = read_direction(entry, problems);
        let first = values.as_ref().map_or("", |values| &values[0].value);
        let is_key = check_key(&entry.key, first, problems);
        let values = values.filter(|_| is_key);
        directions = match (directions, values) {
            (Some(mut all), Some(values)) => {
                all.push((entry.key.clone(), values));
                Some(all)
            }
            _ => None,
        };
    }
    let directions = directions?;
    let are_apart = check_alternatives(directions.iter().map(|(key, _)| key), problems);
    let sizes = directions.iter().map(|(_, values)| values.len() as u64);
    let count = match directions.is_empty() {
        true => 0,
        false => sizes.fold(1, u64::saturating_mul),
    };
    (check_count(item, count, problems) && are_apart).then_some(directions)
}

fn read_list(item: &Item<'_>, problems: &mut Problems) -> Option<Vec<SweptRow>> {
    let rows = item.list_of(
        "a list of tables such as { \"method.time-step\" = 0.1 }",
        problems,
        |row, problems| {
            let pairs = row.pairs("a table of keys with a value each", problems, read_value)?;
            let are_keys: Vec<bool> = pairs
                .iter()
                .map(|(key, value)| check_key(key, &value.value, problems))
                .collect();
            let are_apart = check_alternatives(pairs.iter().map(|(key, _)| key), problems);
            (are_apart && !are_keys.contains(&false)).then_some(pairs)
        },
    )?;
    check_count(item, rows.len() as u64, problems).then_some(rows)
}

fn check_count(item: &Item<'_>, count: u64, problems: &mut Problems) -> bool {
    if (1..=MOST_SETTINGS).contains(&count) {
        return true;
    }
    problems.push(
        SceneProblemCause::Shape {
            what: item.title.clone(),
            found: format!("{count} settings"),
            expected: format!("1 to {MOST_SETTINGS}"),
        },
        item.place(),
    );
    false
}

/// A list of values, or a range.
fn read_direction(item: &Item<'_>, problems: &mut Problems) -> Option<Vec<Located<String>>> {
    if item.is_table() {
        return read_range(item, problems);
    }
    let expected =
        "a list of values, { range = [from, to, count] } or { logarithmic = [from, to, count] }";
    let values = item.list_of(expected, problems, read_value)?;
    if values.is_empty() {
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found: "no value".to_owned(),
                expected: "at least one".to_owned(),
            },
            item.place(),
        );
        return None;
    }
    Some(values)
}

/// A value as it is written; numbers are finite.
fn read_value(item: &Item<'_>, problems: &mut Problems) -> Option<Located<String>> {
    if item.is_number() {
        item.number(problems)?;
    }
    if item.is_list() {
        item.list_of("a list", problems, read_value)?;
    }
    if item.is_table() {
        item.pairs("a table", problems, read_value)?;
    }
    Some(Located::new(item.written().to_owned(), item.place()))
}

/// Equidistant values, or such of equal ratios; both ends are among them.
fn read_range(item: &Item<'_>, problems: &mut Problems) -> Option<Vec<Located<String>>> {
    let table = item.table(
        &item.title,
        "a table such as { range = [0.5, 1, 50] }",
        problems,
    )?;
    table.only(&GRID_RANGES, problems);
    let [chosen] = table.items.as_slice() else {
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found: format!("{} keys", table.items.len()),
                expected: "range or logarithmic".to_owned(),
            },
            item.place(),
        );
        return None;
    };
    let numbers = chosen.list_of("[from, to, count]", problems, Item::number)?;
    let is_logarithmic = chosen.key.value == "logarithmic";
    let mut refuse = |place: Place, expected: &str| {
        problems.push(
            SceneProblemCause::Shape {
                what: chosen.title.clone(),
                found: chosen.written().to_owned(),
                expected: expected.to_owned(),
            },
            place,
        );
        None
    };
    let [from, to, number] = numbers.as_slice() else {
        return refuse(chosen.place(), "[from, to, count]");
    };
    let (ends, count) = ([from, to].map(|end| end.value.value), number.value.value);
    if !(2.0..=MOST_SETTINGS as f64).contains(&count) || libm::floor(count) != count {
        let expected = format!("[from, to, count], count a whole number from 2 to {MOST_SETTINGS}");
        return refuse(number.place(), &expected);
    }
    if is_logarithmic && ends.iter().any(|end| *end <= 0.0) {
        return refuse(chosen.place(), "positive ends");
    }
    let is_whole = |literal: &str| !literal.contains(['.', 'e', 'E']);
    let are_whole = is_whole(&from.value.literal) && is_whole(&to.value.literal);
    let last = count as u64 - 1;
    let value = |k: u64| {
        let s = k as f64 / last as f64;
        match (k, is_logarithmic) {
            (0, _) => ends[0],
            (k, _) if k == last => ends[1],
            (_, false) => ends[0] * (1.0 - s) + ends[1] * s,
            (_, true) => libm::exp(libm::log(ends[0]) * (1.0 - s) + libm::log(ends[1]) * s),
        }
    };
    let written = |value: f64| match are_whole && value == libm::floor(value) {
        true => format!("{value:.0}"),
        false => format!("{value:?}"),
    };
    let values = (0..=last).map(|k| Located::new(written(value(k)), chosen.place()));
    Some(values.collect())
}

/// Whether a key is one that `--set` takes and that settings may differ in.
fn check_key(key: &SweptKey, value: &str, problems: &mut Problems) -> bool {
    match refuse_key(&key.value, value) {
        None => true,
        Some(cause) => {
            problems.push(cause, key.place());
            false
        }
    }
}

/// Why settings may not differ in a key, of which `value` is one value.
pub fn refuse_key(key: &str, value: &str) -> Option<SceneProblemCause> {
    let refuse = |reason: &str| SceneProblemCause::Swept {
        key: key.to_owned(),
        reason: reason.to_owned(),
    };
    let Some(keys) = parse_path(key) else {
        return Some(refuse(NO_PATH));
    };
    let names: Vec<&str> = keys.iter().map(Key::get).collect();
    let plain = names.join(".");
    if key != plain {
        return Some(refuse(&format!(
            "a key has one spelling here: write `{plain}`"
        )));
    }
    let is_within = |shared: &str| {
        let rest = key.strip_prefix(shared);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    if let Some((_, instead)) = SHARED.iter().find(|(shared, _)| is_within(shared)) {
        return Some(refuse(instead));
    }
    match check_path(&keys, key, value) {
        Ok(()) => None,
        Err((SceneProblemCause::Override { reason, .. }, _)) => Some(refuse(&reason)),
        Err((cause, _)) => Some(cause),
    }
}

/// Whether no two keys of one setting say the same thing.
fn check_alternatives<'k>(
    keys: impl Iterator<Item = &'k SweptKey>,
    problems: &mut Problems,
) -> bool {
    let keys: Vec<&SweptKey> = keys.collect();
    let names: Vec<&str> = keys.iter().map(|key| key.value.as_str()).collect();
    let Some((first, second, advice)) = conflict(&names) else {
        return true;
    };
    problems.push(
        SceneProblemCause::Conflict {
            first: keys[first].value.clone(),
            second: keys[second].value.clone(),
            advice,
        },
        keys[second].place(),
    );
    false
}

/// Two keys of which the later one undoes the other where both are set in this order, by their places, and what to do.
pub fn conflict(keys: &[&str]) -> Option<(usize, usize, String)> {
    (0..keys.len()).find_map(|second| {
        let later = keys[second];
        keys[..second].iter().enumerate().find_map(|(first, key)| {
            if alternatives(key, later) {
                let advice = "each replaces the other: keep one".to_owned();
                return Some((first, second, advice));
            }
            // A part that is named behind its own parameters forgets them.
            let within = key.strip_prefix(later);
            let is_undone = within.is_some_and(|rest| rest.starts_with('.'));
            let advice = format!("`{later}` replaces all keys within it: name it first");
            is_undone.then_some((first, second, advice))
        })
    })
}
