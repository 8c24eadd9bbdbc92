//! `bracket = …`: the ways to write a Poisson tensor.

use super::error::SceneProblemCause;
use super::lie_algebra::{LieAlgebraSpec, read_lie_algebra};
use super::located::{Located, Number};
use super::reader::{Item, Problems, Table};
use super::schema::{BRACKET, has, names};
use super::suggest::nearest;

/// How the Poisson tensor is given.
#[derive(Clone, Debug, PartialEq)]
pub enum BracketSpec {
    /// Entries `"x1,x2" = "formula"` for {x1, x2}.
    Entries(Vec<(Located<String>, Located<String>)>),
    /// The linear bracket of a Lie algebra.
    LieAlgebra(LieAlgebraSpec),
    /// {x_i, x_j} = a_ij x_i x_j; the rows of the square matrix a.
    LogCanonical(Vec<Vec<Located<Number>>>),
    /// Positions and velocities in a magnetic field B with v' = v × B; its components' formulas.
    MagneticField(Vec<Located<String>>),
    /// Π = −(dϑ)⁻¹; the formulas of ϑ's components.
    OneForm(Vec<Located<String>>),
    /// Π = −ω⁻¹; entries `"x1,x2" = "formula"` for ω_12.
    TwoForm(Vec<(Located<String>, Located<String>)>),
}

/// What `magnetic-field` was once called, with another sign.
const MAGNETIC: &str = "magnetic";

/// Reads the value of `bracket`.
pub(super) fn read_bracket(item: &Item<'_>, problems: &mut Problems) -> Option<BracketSpec> {
    let table = item.table("bracket", "a table", problems)?;
    if let Some(old) = table.get(MAGNETIC) {
        problems.push(SceneProblemCause::MagneticSign, old.key.place());
        return None;
    }
    let kind = table
        .items
        .iter()
        .find(|entry| has(&BRACKET, &entry.key.value));
    let Some(kind) = kind else {
        return entries(&table, problems).map(BracketSpec::Entries);
    };
    let mut alone = true;
    for other in table
        .items
        .iter()
        .filter(|other| other.key.value != kind.key.value)
    {
        alone = false;
        problems.push(
            SceneProblemCause::Conflict {
                first: kind.key.value.clone(),
                second: other.key.value.clone(),
                advice: format!(
                    "`{}` gives the whole bracket; keep one of them",
                    kind.key.value
                ),
            },
            other.key.place(),
        );
    }
    let spec = match kind.key.value.as_str() {
        "lie-algebra" => read_lie_algebra(kind, problems).map(BracketSpec::LieAlgebra),
        "magnetic-field" => kind
            .list_of("a list of formulas", problems, Item::formula)
            .map(BracketSpec::MagneticField),
        "one-form" => kind
            .list_of("a list of formulas", problems, Item::formula)
            .map(BracketSpec::OneForm),
        "two-form" => kind
            .table("two-form", "a table of pairs of variables", problems)
            .and_then(|table| entries(&table, problems))
            .map(BracketSpec::TwoForm),
        _ => kind.square_matrix(problems).map(BracketSpec::LogCanonical),
    };
    spec.filter(|_| alone)
}

/// Formulas by pairs of variables.
fn entries(
    table: &Table<'_>,
    problems: &mut Problems,
) -> Option<Vec<(Located<String>, Located<String>)>> {
    let items = table.items.iter();
    let entries: Vec<_> = items
        .map(|entry| {
            check_pair(entry, problems);
            Some((entry.key.clone(), entry.formula(problems)?))
        })
        .collect();
    entries.into_iter().collect()
}

fn check_pair(entry: &Item<'_>, problems: &mut Problems) {
    let key = &entry.key.value;
    let parts: Vec<_> = key.split(',').map(str::trim).collect();
    if parts.len() != 2 || parts.iter().any(|part| part.is_empty()) {
        problems.push(
            SceneProblemCause::BracketKey {
                key: key.clone(),
                nearest: nearest(key, names(&BRACKET)),
            },
            entry.key.place(),
        );
    }
}
