//! What changed between two scenes: keys, with the value before and after.

use std::collections::BTreeMap;

use toml_edit::{DocumentMut, Item, TableLike, Value};

/// The most changes that a message shows.
const MOST_CHANGES: usize = 12;

/// Values by dotted keys, in the order they are written.
type Entries = Vec<(String, String)>;

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

/// The keys whose values differ; empty when two texts are the same
/// scene but for comments and spaces, `None` when one is not TOML.
///
/// Values are compared as they are written: 0.1 and 0.10 differ, since decimals are exact. The
/// order of keys counts, because that of variables, families and Casimirs does.
pub(super) fn changed_keys(before: &str, after: &str) -> Option<Vec<Change>> {
    let (before, after) = (entries(before)?, entries(after)?);
    if before == after {
        return Some(Vec::new());
    }
    let values = |entries: &Entries| entries.iter().cloned().collect::<BTreeMap<_, _>>();
    let (old, new) = (values(&before), values(&after));
    let mut changes = Vec::new();
    for (key, value) in &before {
        match new.get(key) {
            Some(given) if given == value => {}
            Some(given) => changes.push(Change::of(key, value, given)),
            None => changes.push(Change::of(key, value, "not given")),
        }
    }
    for (key, value) in after.iter().filter(|(key, _)| !old.contains_key(key)) {
        changes.push(Change::of(key, "not given", value));
    }
    if changes.is_empty() {
        changes.push(Change {
            key: None,
            text: "the keys stand in another order".to_owned(),
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

fn entries(text: &str) -> Option<Entries> {
    let document = text.parse::<DocumentMut>().ok()?;
    let mut entries = Vec::new();
    collect("", document.as_table(), &mut entries);
    Some(entries)
}

fn collect(prefix: &str, table: &dyn TableLike, entries: &mut Entries) {
    for (key, item) in table.iter() {
        let path = if prefix.is_empty() {
            key.to_owned()
        } else {
            format!("{prefix}.{key}")
        };
        match (item.as_table_like(), item) {
            (Some(inner), _) => collect(&path, inner, entries),
            (None, Item::Value(value)) => entries.push((path, written(value))),
            (None, other) => entries.push((path, other.to_string().trim().to_owned())),
        }
    }
}

/// A value on one line, without the comments and spaces around it.
fn written(value: &Value) -> String {
    match value {
        Value::Array(array) => {
            let items: Vec<String> = array.iter().map(written).collect();
            format!("[{}]", items.join(", "))
        }
        Value::InlineTable(table) => {
            let items: Vec<String> = table
                .iter()
                .map(|(key, value)| format!("{key} = {}", written(value)))
                .collect();
            format!("{{ {} }}", items.join(", "))
        }
        scalar => scalar.clone().decorated("", "").to_string(),
    }
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
            Some(vec!["the keys stand in another order".to_owned()])
        );
        assert_eq!(changed_keys(before, "[a"), None);
    }

    #[test]
    fn a_long_list_is_cut() {
        let change = |k: u32| Change::of(&k.to_string(), "0", "1");
        let lines = listed(&(0..20).map(change).collect::<Vec<_>>());
        assert_eq!(lines.lines().count(), 13);
        assert!(lines.ends_with("… and 8 more"));
    }
}
