//! `bracket = …`: the ways to write a Poisson tensor.

use super::canonical::{Coordinates, read_pairs};
use super::error::SceneProblemCause;
use super::lie_algebra::{LieAlgebraSpec, read_lie_algebra};
use super::located::{Located, Number};
use super::reader::{Item, Problems, Table};
use super::shape::{has, names};
use super::suggest::nearest;
use super::system_schema::{BRACKET, SUM, SUMMAND};

/// How the Poisson tensor is given.
#[derive(Clone, Debug, PartialEq)]
pub enum BracketSpec {
    /// Entries `"x1,x2" = "formula"` for {x1, x2}.
    Entries(Vec<(Located<String>, Located<String>)>),
    /// Contact coordinates: entries of pairs q, p, beside one variable s.
    Contact(Vec<(Located<String>, Located<String>)>),
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
    /// The direct sum of brackets over variables of their own.
    Sum(Vec<SummandSpec>),
}

impl BracketSpec {
    /// Its formulas, those of the summands of a sum and their constraints among them.
    pub fn formulas(&self) -> Vec<&Located<String>> {
        match self {
            Self::Entries(entries) | Self::Contact(entries) | Self::TwoForm(entries) => {
                entries.iter().map(|(_, formula)| formula).collect()
            }
            Self::MagneticField(formulas) | Self::OneForm(formulas) => formulas.iter().collect(),
            Self::LieAlgebra(_) | Self::LogCanonical(_) => Vec::new(),
            Self::Sum(summands) => (summands.iter())
                .flat_map(|summand| {
                    let own = summand.bracket.value.formulas();
                    own.into_iter().chain(&summand.constraints)
                })
                .collect(),
        }
    }
}

/// A summand of a direct sum.
#[derive(Clone, Debug, PartialEq)]
pub struct SummandSpec {
    /// Names of single variables and of families.
    pub variables: Vec<Located<String>>,
    /// Its bracket, which is no sum.
    pub bracket: Located<BracketSpec>,
    /// Second-class constraints, for Dirac's bracket.
    pub constraints: Vec<Located<String>>,
}

/// Former name of `magnetic-field`, which had another sign.
const MAGNETIC: &str = "magnetic";

/// Reads the value of `bracket`, of these coordinates.
pub(super) fn read_bracket(
    item: &Item<'_>,
    coordinates: &Coordinates,
    problems: &mut Problems,
) -> Option<BracketSpec> {
    if item.is_string() {
        let words = [("canonical", false), ("contact", true)];
        let is_contact = item.word("kind of bracket", &words, problems)?;
        return match is_contact {
            false => coordinates
                .by_names(&item.place(), problems)
                .map(BracketSpec::Entries),
            true => coordinates
                .paired()
                .by_names(&item.place(), problems)
                .map(BracketSpec::Contact),
        };
    }
    let table = item.table("bracket", "a table or \"canonical\"", problems)?;
    if let Some(old) = table.get(MAGNETIC) {
        problems.push(SceneProblemCause::MagneticSign, old.key.place());
        return None;
    }
    let kind = table
        .items
        .iter()
        .find(|entry| has(&BRACKET, &entry.key.value) || has(&SUM, &entry.key.value));
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
        let advice = format!(
            "`{}` gives the whole bracket; keep one of them",
            kind.key.value
        );
        problems.conflict(&kind.key.value, other, advice);
    }
    let spec = match kind.key.value.as_str() {
        "canonical" => read_pairs(kind, problems)
            .and_then(|pairs| coordinates.by_pairs(&pairs, problems))
            .map(BracketSpec::Entries),
        "contact" => read_pairs(kind, problems)
            .and_then(|pairs| coordinates.by_pairs(&pairs, problems))
            .map(BracketSpec::Contact),
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
        "sum" => kind
            .list_of("a list of summands", problems, |item, problems| {
                summand(item, coordinates, problems)
            })
            .map(BracketSpec::Sum),
        _ => kind.square_matrix(problems).map(BracketSpec::LogCanonical),
    };
    spec.filter(|_| alone)
}

/// `{ variables = […], bracket = {…} }`.
fn summand(
    item: &Item<'_>,
    coordinates: &Coordinates,
    problems: &mut Problems,
) -> Option<SummandSpec> {
    let table = item.table(&item.title, "a table", problems)?;
    table.only(&SUMMAND, problems);
    let variables = table
        .require("variables", "variables = [\"q\", \"p\"]", problems)
        .and_then(|item| item.list_of("a list of names", problems, Item::string))
        .map(|names| coordinates.in_components(names));
    let bracket = table
        .require("bracket", "bracket = { \"q,p\" = \"-1\" }", problems)
        .and_then(|item| {
            let chosen = coordinates.only(variables.as_deref().unwrap_or_default());
            let spec = read_bracket(item, &chosen, problems)?;
            Some(Located::new(spec, item.place()))
        });
    let constraints = match table.get("constraints") {
        Some(item) => item.list_of("a list of formulas", problems, Item::formula),
        None => Some(Vec::new()),
    };
    let bracket = bracket?;
    let second = match &bracket.value {
        BracketSpec::Sum(_) => Some((
            "sum",
            "a summand cannot be a sum: list its summands with the others",
        )),
        BracketSpec::Contact(_) => Some((
            "contact",
            "a contact system cannot be a summand: write all its pairs with one variable s",
        )),
        _ => None,
    };
    if let Some((second, advice)) = second {
        problems.push(
            SceneProblemCause::Conflict {
                first: "sum".to_owned(),
                second: second.to_owned(),
                advice: advice.to_owned(),
            },
            bracket.place(),
        );
        return None;
    }
    Some(SummandSpec {
        variables: variables?,
        bracket,
        constraints: constraints?,
    })
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

/// The parts of a key between commas that stand outside of brackets: `s.x[i,j]` and `s.y[i,j]` of `s.x[i,j],s.y[i,j]`.
fn pair(key: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth) = (Vec::new(), 0, 0_usize);
    for (at, c) in key.char_indices() {
        match c {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&key[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&key[start..]);
    parts
}

fn check_pair(entry: &Item<'_>, problems: &mut Problems) {
    let key = &entry.key.value;
    let parts: Vec<&str> = pair(key).into_iter().map(str::trim).collect();
    if parts.len() != 2 || parts.iter().any(|part| part.is_empty()) {
        problems.push(
            SceneProblemCause::BracketKey {
                key: key.clone(),
                nearest: nearest(key, names(&BRACKET).chain(names(&SUM))),
            },
            entry.key.place(),
        );
    }
}
