//! The JSON object of a field in Boozer coordinates, name after name.

use std::path::Path;

use leafwise::equilibrium::{BoozerData, EquilibriumError};
use leafwise::scene::read_npy;
use serde_json::{Map, Value};

/// The object with all its names.
const SHAPE: &str = "{\"periods\": 5, \"psi\": 0.4, \"s\": […], \"iota\": […], \"G\": […], \"I\": […], \"B\": \"B.npy\"}";

/// Its names; `I` may be left out.
const NAMES: [&str; 7] = ["periods", "psi", "s", "iota", "G", "I", "B"];

const NUMBER: &str = "a number";
const NUMBERS: &str = "a list of numbers";

/// The numbers of a field by the text of its file.
///
/// # Errors
/// [`EquilibriumError`] where an entry is none, by its place.
pub(super) fn read(path: &Path, text: &str) -> Result<BoozerData, EquilibriumError> {
    let odd = |message: String| EquilibriumError::Odd(message);
    let value: Value = serde_json::from_str(text).map_err(|error| {
        let line = text.lines().nth(error.line().saturating_sub(1));
        let ahead = line.and_then(|line| line.get(error.column().saturating_sub(4)..));
        let is_special = ahead.is_some_and(|ahead| {
            let near: String = ahead.chars().take(8).collect();
            ["NaN", "nan", "Inf", "inf"]
                .iter()
                .any(|word| near.contains(word))
        });
        let hint = if is_special {
            ": JSON has no NaN and no infinity, and a field neither"
        } else {
            ""
        };
        odd(format!("no JSON: {error}{hint}"))
    })?;
    let Value::Object(fields) = value else {
        return Err(odd(format!("no field in Boozer coordinates, {SHAPE}")));
    };
    if let Some(name) = fields.keys().find(|name| !NAMES.contains(&name.as_str())) {
        return Err(odd(format!(
            "`{name}` is not part of a field in Boozer coordinates, which has {}",
            NAMES.join(", ")
        )));
    }
    let list = |name: &str| numbers(of(&fields, name)?, name);
    let (nodes, strength) = strength(path, of(&fields, "B")?)?;
    Ok(BoozerData {
        periods: whole(of(&fields, "periods")?, "periods")?,
        edge_flux: number(of(&fields, "psi")?, "psi")?,
        s: list("s")?,
        iota: list("iota")?,
        g: list("G")?,
        i: match fields.contains_key("I") {
            true => list("I")?,
            false => Vec::new(),
        },
        nodes,
        strength,
    })
}

fn of<'a>(fields: &'a Map<String, Value>, name: &str) -> Result<&'a Value, EquilibriumError> {
    fields.get(name).ok_or_else(|| {
        EquilibriumError::Odd(format!(
            "`{name}` is missing from a field in Boozer coordinates, {SHAPE}"
        ))
    })
}

fn refused(value: &Value, place: impl Into<String>, expected: &'static str) -> EquilibriumError {
    let found = match value {
        Value::Null => "null".to_owned(),
        Value::Bool(truth) => truth.to_string(),
        Value::Number(number) => number.to_string(),
        Value::String(text) => format!("the text \"{text}\""),
        Value::Array(items) => format!("a list of {}", items.len()),
        Value::Object(_) => "an object".to_owned(),
    };
    EquilibriumError::Entry {
        place: place.into(),
        found,
        expected,
    }
}

fn number(value: &Value, place: impl Into<String>) -> Result<f64, EquilibriumError> {
    value.as_f64().ok_or_else(|| refused(value, place, NUMBER))
}

/// A whole number; 5.0 is one.
fn whole(value: &Value, place: &str) -> Result<u32, EquilibriumError> {
    let number = number(value, place)?;
    let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
    match is_whole {
        true => Ok(number as u32),
        false => Err(refused(value, place, "a whole number, such as 5")),
    }
}

fn numbers(value: &Value, place: &str) -> Result<Vec<f64>, EquilibriumError> {
    let items = value
        .as_array()
        .ok_or_else(|| refused(value, place, NUMBERS))?;
    let each = items.iter().enumerate();
    each.map(|(at, item)| number(item, format!("{place}[{at}]")))
        .collect()
}

/// |B| as one list, and its nodes of θ and ζ.
fn strength(path: &Path, value: &Value) -> Result<([usize; 2], Vec<f64>), EquilibriumError> {
    const EXPECTED: &str =
        "lists of numbers over surfaces, theta and zeta, or the name of an array, \"B.npy\"";
    let odd = EquilibriumError::Odd;
    if let Value::String(name) = value {
        let beside = path.parent().unwrap_or(Path::new("")).join(name);
        let array = read_npy(&beside).map_err(odd)?;
        return match array.shape[..] {
            [_, along_theta, along_zeta] => Ok(([along_theta, along_zeta], array.numbers)),
            _ => Err(odd(format!(
                "{} has the shape {:?}: `B` has three axes, of surfaces, theta and zeta",
                beside.display(),
                array.shape
            ))),
        };
    }
    let list = |value: &Value, place: &str| match value {
        Value::Array(items) => Ok(items.clone()),
        _ => Err(refused(value, place, EXPECTED)),
    };
    let (mut all, mut nodes) = (Vec::new(), [None; 2]);
    let mut same = |which: usize, count: usize, place: &str| {
        let first = *nodes[which].get_or_insert(count);
        match first == count {
            true => Ok(()),
            false => Err(odd(format!(
                "`{place}` has {count} entries where the first has {first}: `B` has rows of different lengths"
            ))),
        }
    };
    for (k, surface) in list(value, "B")?.iter().enumerate() {
        let place = format!("B[{k}]");
        let rows = list(surface, &place)?;
        same(0, rows.len(), &place)?;
        for (j, row) in rows.iter().enumerate() {
            let place = format!("B[{k}][{j}]");
            if !row.is_array() {
                return Err(refused(row, place, EXPECTED));
            }
            let row = numbers(row, &place)?;
            same(1, row.len(), &place)?;
            all.extend(row);
        }
    }
    Ok((nodes.map(Option::unwrap_or_default), all))
}
