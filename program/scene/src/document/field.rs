//! Values that a variable, the sites of a family or a parameter of every site begin with.

use std::sync::Arc;

use leafwise_core::NumberArray;

use super::error::SceneProblemCause;
use super::located::{Located, Number, Place};
use super::reader::{Item, Problems};
use super::system_schema::COLUMN;
use super::tables::values;

/// Numbers of one variable, or of all sites of a family.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldSpec {
    /// A formula of the site's index, of `N` and of parameters.
    Formula(Located<String>),
    /// A number for each site.
    Numbers(Vec<Located<Number>>, Place),
    /// Rows of numbers, those of a matrix.
    Rows(Arc<NumberArray>, Place),
    /// A number for each site, each in a row of a file beside the scene.
    File {
        /// The file.
        file: Located<String>,
        /// Its column, where it has several.
        column: Option<Located<String>>,
    },
}

impl FieldSpec {
    /// The formula, where it is one.
    pub fn formula(&self) -> Option<&Located<String>> {
        match self {
            Self::Formula(formula) => Some(formula),
            Self::Numbers(..) | Self::Rows(..) | Self::File { .. } => None,
        }
    }
}

/// The family of a key such as `J[i]` or `J[3]`; `None` for a name alone.
pub(super) fn family_of(key: &str) -> Option<&str> {
    key.split_once('[').map(|(name, _)| name.trim())
}

/// Records a site that is named twice, as `b[2]` and `b[02]`.
pub(super) fn check_sites_once<'a>(
    keys: impl IntoIterator<Item = &'a Located<String>>,
    problems: &mut Problems,
) {
    let mut seen: Vec<(&str, u64)> = Vec::new();
    for key in keys {
        let Some((name, rest)) = key.value.split_once('[') else {
            continue;
        };
        let number = rest.trim_end().strip_suffix(']');
        let Some(number) = number.and_then(|number| number.trim().parse().ok()) else {
            continue;
        };
        let site = (name.trim(), number);
        if seen.contains(&site) {
            let name = format!("{}[{number}]", site.0);
            problems.push(SceneProblemCause::Duplicate { name }, key.place());
        }
        seen.push(site);
    }
}

/// A formula, a number, a list of numbers, or `{ file = "j.csv", column = "J" }`.
pub(super) fn read_field(item: &Item<'_>, problems: &mut Problems) -> Option<FieldSpec> {
    let is_whole = item.is_list() || item.is_table();
    if is_whole && !item.key.value.contains('[') {
        let cause = SceneProblemCause::NotOne {
            key: item.key.value.clone(),
            found: if item.is_list() { "a list" } else { "a table" },
        };
        problems.push(cause, item.place());
        return None;
    }
    if item.is_list() && item.has_lists() {
        let rows = values(item, problems)?;
        return Some(FieldSpec::Rows(Arc::new(rows), item.place()));
    }
    if item.is_list() {
        let numbers = item.list_of("a list of numbers", problems, Item::number)?;
        return Some(FieldSpec::Numbers(numbers, item.place()));
    }
    if !item.is_table() {
        return item.formula(problems).map(FieldSpec::Formula);
    }
    let table = item.table(&item.title, "a table", problems)?;
    table.only(&COLUMN, problems);
    let file = table
        .require("file", "file = \"values.csv\"", problems)
        .and_then(|item| item.string(problems));
    let column = match table.get("column") {
        Some(item) => item.string(problems).map(Some),
        None => Some(None),
    };
    Some(FieldSpec::File {
        file: file?,
        column: column?,
    })
}

/// The entries of a table of parameters.
#[derive(Default)]
pub(super) struct Parameters {
    /// Numbers.
    pub(super) numbers: Vec<(Located<String>, Located<Number>)>,
    /// Formulas of other parameters.
    pub(super) formulas: Vec<(Located<String>, Located<String>)>,
    /// Keys with an index: parameters of every site.
    pub(super) sites: Vec<(Located<String>, FieldSpec)>,
}

/// `{ a = 1.0, b = "2*a", "J[i]" = "1 + 0.1*sin(2*pi*i/N)", "J[3]" = 2 }`; keys that `skip` names are left out.
pub(super) fn read_parameters(
    item: &Item<'_>,
    has_sites: bool,
    skip: impl Fn(&str) -> bool,
    problems: &mut Problems,
) -> Option<Parameters> {
    let table = item.table(&item.title, "a table of numbers", problems)?;
    let (mut numbers, mut fields) = (Some(Vec::new()), Some(Vec::new()));
    let mut formulas = Some(Vec::new());
    for entry in &table.items {
        let key = &entry.key;
        if skip(&key.value) {
            continue;
        }
        if family_of(&key.value).is_some() {
            collect(&mut fields, key, read_field(entry, problems));
        } else if entry.names_others() {
            collect(&mut formulas, key, entry.formula(problems));
        } else if !has_sites || entry.is_number() || entry.is_string() {
            collect(&mut numbers, key, entry.constant(problems));
        } else {
            let expected = format!(
                "a number, where those of all sites are \"{}[i]\"",
                key.value
            );
            entry.wrong_type(&expected, problems);
            numbers = None;
        }
    }
    let fields = fields?;
    check_sites_once(fields.iter().map(|(key, _)| key), problems);
    Some(Parameters {
        numbers: numbers?,
        formulas: formulas?,
        sites: fields,
    })
}

fn collect<T>(
    into: &mut Option<Vec<(Located<String>, T)>>,
    key: &Located<String>,
    value: Option<T>,
) {
    *into = match (into.take(), value) {
        (Some(mut entries), Some(value)) => {
            entries.push((key.clone(), value));
            Some(entries)
        }
        _ => None,
    };
}

/// Records that parameters of every site stand where there are no sites.
pub(super) fn without_sites(key: &Located<String>, problems: &mut Problems) {
    problems.push(
        SceneProblemCause::WithoutSites {
            key: key.value.clone(),
        },
        key.place(),
    );
}
