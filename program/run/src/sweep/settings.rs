//! The settings of a sweep, by number.

use std::collections::BTreeSet;

use sha2::{Digest, Sha256};
use toml_edit::Value;

use crate::csv;
use leafwise_scene::compose::Refusal;
use leafwise_scene::document::{
    Located, MOST_SETTINGS, Place, SceneDocument, SettingsSpec, Source, SweepSection, conflict,
    refuse_key,
};
use leafwise_scene::input::read_text;

/// The settings of a sweep: for each of its keys a value as `--set` takes it, or the scene's own.
#[derive(Clone, Debug)]
pub struct Settings {
    keys: Vec<String>,
    values: Values,
    /// The file that they are read from, and the SHA-256 of its text.
    pub(super) file: Option<(String, [u8; 32])>,
}

#[derive(Clone, Debug)]
enum Values {
    Grid(Vec<Vec<String>>),
    Rows(Vec<Vec<Option<String>>>),
}

impl Settings {
    /// Settings of a scene with a `[sweep]` table. A file of them stands beside the scene.
    ///
    /// # Errors
    /// A scene without the table, and a file that holds no settings.
    pub fn of(document: &SceneDocument) -> Result<Self, Refusal> {
        let sweep = section(document)?;
        let text = |value: &Located<String>| value.value.clone();
        Ok(match &sweep.settings {
            SettingsSpec::Grid(directions) => Self {
                keys: directions.iter().map(|(key, _)| text(key)).collect(),
                values: Values::Grid(
                    directions
                        .iter()
                        .map(|(_, values)| values.iter().map(text).collect())
                        .collect(),
                ),
                file: None,
            },
            SettingsSpec::List(rows) => {
                let mut keys: Vec<String> = Vec::new();
                for (key, _) in rows.iter().flatten() {
                    if !keys.contains(&key.value) {
                        keys.push(key.value.clone());
                    }
                }
                let value = |row: &[(Located<String>, Located<String>)], key: &String| {
                    let found = row.iter().find(|(own, _)| own.value == *key);
                    found.map(|(_, value)| text(value))
                };
                let rows = rows
                    .iter()
                    .map(|row| keys.iter().map(|key| value(row, key)).collect())
                    .collect();
                Self {
                    keys,
                    values: Values::Rows(rows),
                    file: None,
                }
            }
            SettingsSpec::File(file) => Self::read(document, &file.value).map_err(|reason| {
                let help = "the keys in the first row, a setting in each other, as\n\
                                system.parameters.a,method.time-step\n0.5,0.1";
                let message = format!("{}: {reason}", file.value);
                let help = Some(help.to_owned());
                Box::new(document.diagnostic(&file.place(), message, "this file", help))
            })?,
        })
    }

    fn read(document: &SceneDocument, file: &str) -> Result<Self, String> {
        let text =
            read_text(&document.directory().join(file)).map_err(|error| error.to_string())?;
        let digest = Sha256::digest(text.as_bytes()).into();
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut rows = csv::rows(text)?.into_iter().peekable();
        let keys = rows.next().ok_or("it is empty")?;
        let mut known = BTreeSet::new();
        for (at, key) in keys.iter().enumerate() {
            let first = rows.peek().and_then(|row| row.get(at));
            if let Some(cause) = refuse_key(key, first.map_or("", String::as_str)) {
                return Err(cause.to_string());
            }
            if !known.insert(key) {
                return Err(format!("it has two columns `{key}`"));
            }
        }
        let rows: Vec<Vec<Option<String>>> = rows
            .zip(2..)
            .map(|(row, number)| {
                if row.len() != keys.len() {
                    let (found, expected) = (row.len(), keys.len());
                    return Err(format!(
                        "row {number} has {found} values, and there are {expected} keys"
                    ));
                }
                let row = row
                    .into_iter()
                    .map(|cell| (!cell.is_empty()).then_some(cell));
                let row: Vec<Option<String>> = row.collect();
                let given = keys.iter().zip(&row).filter(|(_, cell)| cell.is_some());
                let given: Vec<&str> = given.map(|(key, _)| key.as_str()).collect();
                if let Some((first, second, advice)) = conflict(&given) {
                    let (first, second) = (given[first], given[second]);
                    return Err(format!(
                        "row {number}: `{second}` cannot be combined with `{first}`: {advice}"
                    ));
                }
                let is_infinite = |cell: &&String| {
                    let value = cell.trim().parse::<Value>().ok();
                    value
                        .and_then(|v| v.as_float())
                        .is_some_and(|v| !v.is_finite())
                };
                match row.iter().flatten().find(is_infinite) {
                    Some(cell) => Err(format!("row {number} holds {cell}, not a finite number")),
                    None => Ok(row),
                }
            })
            .collect::<Result<_, _>>()?;
        match rows.len() as u64 {
            0 => Err("it has no row of values".to_owned()),
            count if count > MOST_SETTINGS => Err(format!(
                "it has {count} rows, at most {MOST_SETTINGS} are offered"
            )),
            _ => Ok(Self {
                keys,
                values: Values::Rows(rows),
                file: Some((file.to_owned(), digest)),
            }),
        }
    }

    /// The keys, each a column of the table.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// How many settings there are.
    pub fn count(&self) -> u64 {
        match &self.values {
            Values::Grid(directions) => directions.iter().map(|d| d.len() as u64).product(),
            Values::Rows(rows) => rows.len() as u64,
        }
    }

    /// The values of a setting, one for each key, as TOML or a bare word; `None` where the scene's own stays.
    ///
    /// # Panics
    /// For a number beyond the last.
    pub fn values(&self, setting: u64) -> Vec<Option<&str>> {
        match &self.values {
            Values::Rows(rows) => rows[setting as usize]
                .iter()
                .map(Option::as_deref)
                .collect(),
            Values::Grid(directions) => {
                let mut rest = setting as usize;
                let mut values = vec![None; directions.len()];
                for (value, direction) in values.iter_mut().zip(directions).rev() {
                    *value = Some(direction[rest % direction.len()].as_str());
                    rest /= direction.len();
                }
                values
            }
        }
    }

    /// A setting in words.
    pub fn describe(&self, setting: u64) -> String {
        let values = self.values(setting);
        let pairs = self.keys.iter().zip(values);
        let pairs = pairs.filter_map(|(key, value)| Some(format!("{key} = {}", value?)));
        let pairs: Vec<String> = pairs.collect();
        format!("setting {setting} of the sweep, {}", pairs.join(", "))
    }
}

/// A value as a cell shows it: a text without its quotes.
pub(super) fn cell(value: &str) -> String {
    match value.trim().parse::<Value>() {
        Ok(Value::String(text)) => text.into_value(),
        _ => value.trim().to_owned(),
    }
}

/// The scene's `[sweep]` table.
pub(super) fn section(document: &SceneDocument) -> Result<&SweepSection, Refusal> {
    document.sweep.as_ref().ok_or_else(|| {
        let end = document.text.trim_end().len();
        let place = Place {
            source: Source::Scene,
            span: end..end,
        };
        let help = "for example:\n[sweep]\ngrid = { \"method.time-step\" = [0.05, 0.1, 0.2] }";
        Box::new(document.diagnostic(
            &place,
            "the scene has no [sweep] table",
            "[sweep] is missing",
            Some(help.to_owned()),
        ))
    })
}
