//! Differences between two scenes: the keys that changed, with the value before and after.

use std::collections::BTreeMap;

use toml_edit::{DocumentMut, Item, TableLike, Value};

/// The most changes that a message shows.
const MOST_CHANGES: usize = 12;

/// A value with its dotted key.
#[derive(Clone, Debug)]
struct Entry {
    key: String,
    /// As it is written.
    shown: String,
    /// The same with every number spelt in one way.
    meant: String,
}

impl Entry {
    fn of(key: String, value: &Value) -> Self {
        Self {
            key,
            shown: written(value, &|scalar| {
                scalar.clone().decorated("", "").to_string()
            }),
            meant: written(value, &|scalar| match scalar {
                Value::Integer(of) => decimal(&of.value().to_string()),
                Value::Float(of) => decimal(&of.display_repr()),
                other => other.clone().decorated("", "").to_string(),
            }),
        }
    }
}

/// A key whose value differs, or something of the whole scene without one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Change {
    /// The dotted key.
    pub key: Option<String>,
    /// For the reader: `key: before → after`.
    pub text: String,
}

impl Change {
    fn of(key: &str, before: &str, after: &str) -> Self {
        Self {
            key: Some(key.to_owned()),
            text: format!("{key}: {before} → {after}"),
        }
    }
}

/// The keys of a scene and their values in their order, with every number spelt in one way; none of a text that is not TOML.
pub(super) fn meaning(text: &str) -> Vec<(String, String)> {
    let entries = entries(text).unwrap_or_default().into_iter();
    entries.map(|entry| (entry.key, entry.meant)).collect()
}

/// The keys whose values differ; empty when two texts are the same
/// scene but for comments and spaces, `None` when one is not TOML.
///
/// Numbers are compared as exact decimals: 0.1, 0.10 and 1e-1 are one, and so are 1 and 1.0; 0.1 and another decimal of the same
/// double are not. The order of keys counts, because that of variables, families and Casimirs does.
pub(super) fn changed_keys(before: &str, after: &str) -> Option<Vec<Change>> {
    let (before, after) = (entries(before)?, entries(after)?);
    let in_order = |entries: &[Entry]| -> Vec<(String, String)> {
        let entries = entries.iter();
        entries
            .map(|entry| (entry.key.clone(), entry.meant.clone()))
            .collect()
    };
    if in_order(&before) == in_order(&after) {
        return Some(Vec::new());
    }
    fn values(entries: &[Entry]) -> BTreeMap<&str, &Entry> {
        let entries = entries.iter();
        entries.map(|entry| (entry.key.as_str(), entry)).collect()
    }
    let (old, new) = (values(&before), values(&after));
    let mut changes = Vec::new();
    for Entry { key, shown, meant } in &before {
        match new.get(key.as_str()) {
            Some(given) if given.meant == *meant => {}
            Some(given) => changes.push(Change::of(key, shown, &given.shown)),
            None => changes.push(Change::of(key, shown, "not given")),
        }
    }
    let is_new = |entry: &&Entry| !old.contains_key(entry.key.as_str());
    for entry in after.iter().filter(is_new) {
        changes.push(Change::of(&entry.key, "not given", &entry.shown));
    }
    if changes.is_empty() {
        changes.push(Change {
            key: None,
            text: "the keys are in another order".to_owned(),
        });
    }
    Some(changes)
}

/// Changes as lines of a message.
pub(super) fn listed(changes: &[Change]) -> String {
    let shown = changes.iter().take(MOST_CHANGES);
    let mut lines: Vec<String> = shown.map(|change| format!("  {}", change.text)).collect();
    if let Some(more) = changes.len().checked_sub(MOST_CHANGES + 1) {
        lines.push(format!("  … and {} more", more + 1));
    }
    lines.join("\n")
}

fn entries(text: &str) -> Option<Vec<Entry>> {
    let document = text.parse::<DocumentMut>().ok()?;
    let mut entries = Vec::new();
    collect("", document.as_table(), &mut entries);
    Some(entries)
}

fn collect(prefix: &str, table: &dyn TableLike, entries: &mut Vec<Entry>) {
    for (key, item) in table.iter() {
        let path = if prefix.is_empty() {
            key.to_owned()
        } else {
            format!("{prefix}.{key}")
        };
        match (item.as_table_like(), item) {
            (Some(inner), _) => collect(&path, inner, entries),
            (None, Item::Value(value)) => entries.push(Entry::of(path, value)),
            (None, other) => {
                let shown = other.to_string().trim().to_owned();
                let meant = shown.clone();
                entries.push(Entry {
                    key: path,
                    shown,
                    meant,
                });
            }
        }
    }
}

/// A value on one line, without the comments and spaces around it; `scalar` writes what is neither a list nor a table.
fn written(value: &Value, scalar: &dyn Fn(&Value) -> String) -> String {
    match value {
        Value::Array(array) => {
            let items: Vec<String> = array.iter().map(|item| written(item, scalar)).collect();
            format!("[{}]", items.join(", "))
        }
        Value::InlineTable(table) => {
            let items: Vec<String> = table
                .iter()
                .map(|(key, value)| format!("{key} = {}", written(value, scalar)))
                .collect();
            format!("{{ {} }}", items.join(", "))
        }
        other => scalar(other),
    }
}

/// A decimal with no zeros before its first digit nor behind its last: sign, digits, power of ten.
fn decimal(text: &str) -> String {
    let plain = text.replace('_', "").to_ascii_lowercase();
    let (mantissa, power) = plain.split_once('e').unwrap_or((&plain, "0"));
    let (sign, size) = match mantissa.strip_prefix('-') {
        Some(size) => ("-", size),
        None => ("", mantissa.trim_start_matches('+')),
    };
    let (whole, part) = size.split_once('.').unwrap_or((size, ""));
    let digits = format!("{whole}{part}");
    let (Ok(power), true) = (
        power.parse::<i64>(),
        digits.bytes().all(|digit| digit.is_ascii_digit()),
    ) else {
        // inf or nan.
        return plain;
    };
    let digits = digits.trim_start_matches('0');
    let short = digits.trim_end_matches('0');
    if short.is_empty() {
        return format!("{sign}0");
    }
    let zeros = digits.len() - short.len();
    let power = i128::from(power) + zeros as i128 - part.len() as i128;
    format!("{sign}{short}e{power}")
}

#[cfg(test)]
mod tests {
    use super::{Change, changed_keys, listed};

    fn texts(before: &str, after: &str) -> Option<Vec<String>> {
        let changes = changed_keys(before, after)?;
        Some(changes.into_iter().map(|change| change.text).collect())
    }

    #[test]
    fn changes_are_keys_with_both_values() {
        let before = "[method]\nepsilon = 0.1 # small\nh = 2\n[run]\ninitial = [1, 2]\n";
        let after = "[method]\nepsilon = 0.2\n[run]\ninitial = [1,\n 3]\nsteps = 5\n";
        let changes = changed_keys(before, after).expect("two scenes");
        assert_eq!(changes[0].key.as_deref(), Some("method.epsilon"));
        assert_eq!(
            texts(before, after).expect("two scenes"),
            [
                "method.epsilon: 0.1 → 0.2",
                "method.h: 2 → not given",
                "run.initial: [1, 2] → [1, 3]",
                "run.steps: not given → 5",
            ]
        );
    }

    #[test]
    fn comments_and_spaces_are_no_change_and_order_is() {
        let before = "[a]\nx = { y = [1, 2], z = \"t\" }\nw = 1\n";
        let other = "# a comment\n[a]\n\n  x = { y = [ 1,2 ], z=\"t\" } # here\nw = 1\n";
        assert_eq!(changed_keys(before, other), Some(Vec::new()));
        let exchanged = "[a]\nw = 1\nx = { y = [1, 2], z = \"t\" }\n";
        assert_eq!(
            texts(before, exchanged),
            Some(vec!["the keys are in another order".to_owned()])
        );
        assert_eq!(changed_keys(before, "[a"), None);
    }

    #[test]
    fn numbers_are_compared_as_numbers() {
        let same = [
            "1", "1.0", "1e0", "+1.00", "10e-1", "0.1e1", "1_0e-1", "0x1",
        ];
        let other = [
            "1.0000000000000000001",
            "-1",
            "1.1",
            "2",
            "\"1\"",
            "true",
            "[1]",
        ];
        let scene = |value: &str| format!("[a]\nk = {value}\nx = {{ y = [0.1, {value}] }}\n");
        for value in same {
            let changes = changed_keys(&scene("1"), &scene(value));
            assert_eq!(changes, Some(Vec::new()), "{value}");
        }
        for value in other {
            let changes = texts(&scene("1.0"), &scene(value)).expect("two scenes");
            assert_eq!(changes[0], format!("a.k: 1.0 → {value}"));
        }
        let zeros = ["0", "0.0", "-0", "0e5"].map(scene);
        assert!(
            zeros
                .iter()
                .all(|zero| changed_keys(&zeros[0], zero) == Some(Vec::new()))
        );
        assert_ne!(changed_keys(&scene("0"), &scene("-0.0")), Some(Vec::new()));
        assert_eq!(changed_keys(&scene("inf"), &scene("inf")), Some(Vec::new()));
        assert_ne!(
            changed_keys(&scene("inf"), &scene("-inf")),
            Some(Vec::new())
        );
    }

    #[test]
    fn a_long_list_is_cut() {
        let change = |k: u32| Change::of(&k.to_string(), "0", "1");
        let lines = listed(&(0..20).map(change).collect::<Vec<_>>());
        assert_eq!(lines.lines().count(), 13);
        assert!(lines.ends_with("… and 8 more"));
    }
}
