//! Reads the families of a lattice, the lengths of their axes and their ends.

use leafwise_expression::syntax::AXES;

use super::error::SceneProblemCause;
use super::located::Located;
use super::reader::{Item, Problems};
use super::site_names::NamedSites;
use super::system_schema::VECTORS;
use super::system_section::{Boundary, SystemSection, VectorFamily};

/// The largest dimension of a lattice that is written out site by site; longer ones are templates.
pub const DENSE_LIMIT: usize = 24;

/// More sites than a run can hold in memory, so that a slip of the keyboard is reported as one.
const MOST_SITES: u64 = 100_000_000;

fn length(item: &Item<'_>, problems: &mut Problems) -> Option<Located<usize>> {
    let length = item.whole_in(1, MOST_SITES, problems)?;
    Some(length.map(|length| usize::try_from(length).unwrap_or(usize::MAX)))
}

/// The length of a chain: `64`, `[64]` or the names of its sites, which are added to `names`.
pub(super) fn chain_length(
    item: &Item<'_>,
    names: &mut Vec<NamedSites>,
    problems: &mut Problems,
) -> Option<Located<usize>> {
    let lengths = lengths(item, names, problems)?;
    if let [length] = lengths.value[..] {
        return Some(lengths.map(|_| length));
    }
    problems.push(
        SceneProblemCause::Shape {
            what: item.title.clone(),
            found: format!("{} lengths", lengths.value.len()),
            expected: "one: this system is a chain".to_owned(),
        },
        item.place(),
    );
    None
}

/// The lengths of a family's axes: `64`, `[64, 64]` or `["Sun", "Earth"]`, names that are added to `names`.
fn lengths(
    item: &Item<'_>,
    names: &mut Vec<NamedSites>,
    problems: &mut Problems,
) -> Option<Located<Vec<usize>>> {
    if !item.is_list() {
        return Some(length(item, problems)?.map(|length| vec![length]));
    }
    if item.has_texts() {
        let own = item.list_of("a list of names", problems, Item::string)?;
        let length = Located::new(vec![own.len()], item.place());
        names.push(Located::new(own, item.place()));
        return Some(length);
    }
    let lengths = item.list_of("a list of lengths, one an axis", problems, length)?;
    let lengths: Vec<usize> = lengths.into_iter().map(|length| length.value).collect();
    let sites = lengths
        .iter()
        .try_fold(1_usize, |all, own| all.checked_mul(*own));
    let is_held = sites.is_some_and(|sites| sites as u64 <= MOST_SITES);
    if lengths.is_empty() {
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found: "no lengths".to_owned(),
                expected: format!(
                    "the number of sites, as 64, or 2 to {AXES} lengths, as [64, 64]"
                ),
            },
            item.place(),
        );
        return None;
    }
    if !(1..=AXES).contains(&lengths.len()) || !is_held {
        let found = format!(
            "{} axes, {} sites",
            lengths.len(),
            sites.unwrap_or(usize::MAX)
        );
        let expected = format!("1 to {AXES} axes and at most {MOST_SITES} sites");
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found,
                expected,
            },
            item.place(),
        );
        return None;
    }
    Some(Located::new(lengths, item.place()))
}

/// Names with one value each.
pub(super) type Named<T> = Vec<(Located<String>, Located<T>)>;

/// The numbers of sites of families, and the axes that they share where these are several.
pub(super) fn on_axes(
    families: Named<Vec<usize>>,
    problems: &mut Problems,
) -> Option<(Named<usize>, Vec<usize>)> {
    let several = families.iter().find(|(_, lengths)| lengths.value.len() > 1);
    let axes = several.map_or_else(Vec::new, |(_, lengths)| lengths.value.clone());
    if let Some((first, _)) = several
        && let Some((name, other)) = families.iter().find(|(_, own)| own.value != axes)
    {
        problems.push(
            SceneProblemCause::Shape {
                what: format!("the family `{}`", name.value),
                found: format!("lengths {:?}", other.value),
                expected: format!(
                    "{axes:?}, as `{}` has: on a lattice of several axes all families have the same",
                    first.value
                ),
            },
            other.place(),
        );
        return None;
    }
    let sites = |lengths: Located<Vec<usize>>| lengths.map(|lengths| lengths.iter().product());
    let families = families.into_iter();
    let families = families.map(|(name, lengths)| (name, sites(lengths)));
    Some((families.collect(), axes))
}

/// `"open"`, or `["periodic", "open"]`.
pub(super) fn boundaries(
    item: &Item<'_>,
    problems: &mut Problems,
) -> Option<Located<Vec<Boundary>>> {
    let one = |item: &Item<'_>, problems: &mut Problems| {
        let choices = [("periodic", Boundary::Periodic), ("open", Boundary::Open)];
        item.word("boundary", &choices, problems)
    };
    if !item.is_list() {
        return Some(Located::new(vec![one(item, problems)?], item.place()));
    }
    let each = item.list_of("a list of boundaries, one an axis", problems, one)?;
    Some(Located::new(each, item.place()))
}

/// A list of boundaries has one for each axis.
pub(super) fn check_boundaries(system: &SystemSection, problems: &mut Problems) {
    let Some(boundary) = &system.boundary else {
        return;
    };
    let (axes, found) = (system.axes.len().max(1), boundary.value.len());
    if found != 1 && found != axes {
        problems.push(
            SceneProblemCause::Shape {
                what: "system.boundary".to_owned(),
                found: format!("{found} boundaries"),
                expected: format!("one for all axes, or one for each of the {axes}"),
            },
            boundary.place(),
        );
    }
}

/// Families of scalars, those of vectors by their components, and the latter.
#[derive(Default)]
pub(super) struct Families {
    pub scalars: Named<Vec<usize>>,
    pub vectors: Vec<VectorFamily>,
    /// Lists of names of sites.
    pub names: Vec<NamedSites>,
}

/// `{ x = 100, q = ["Sun", "Earth"], s = { components = ["x", "y", "z"], length = 100 } }`.
pub(super) fn read_families(item: &Item<'_>, problems: &mut Problems) -> Option<Families> {
    let table = item.table(&item.title, "a table of lengths", problems)?;
    let mut families = Families::default();
    let mut is_whole = true;
    for entry in &table.items {
        if !entry.is_table() {
            match lengths(entry, &mut families.names, problems) {
                Some(length) => families.scalars.push((entry.key.clone(), length)),
                None => is_whole = false,
            }
            continue;
        }
        let Some((vector, length)) = vectors(entry, &mut families.names, problems) else {
            is_whole = false;
            continue;
        };
        for component in &vector.components {
            let name = component.clone().map(|name| vector.family(&name));
            families.scalars.push((name, length.clone()));
        }
        families.vectors.push(vector);
    }
    is_whole.then_some(families)
}

/// `{ components = ["x", "y", "z"], length = 100 }`.
fn vectors(
    item: &Item<'_>,
    names: &mut Vec<NamedSites>,
    problems: &mut Problems,
) -> Option<(VectorFamily, Located<Vec<usize>>)> {
    let table = item.table(&item.title, "a table", problems)?;
    table.only(&VECTORS, problems);
    let components = table
        .require("components", "components = [\"x\", \"y\", \"z\"]", problems)
        .and_then(|item| {
            let names = item.list_of("a list of names", problems, Item::string)?;
            if names.is_empty() {
                problems.push(
                    SceneProblemCause::Shape {
                        what: "components".to_owned(),
                        found: "no entry".to_owned(),
                        expected: "at least one name".to_owned(),
                    },
                    item.place(),
                );
            }
            Some(names)
        });
    let length = table
        .require("length", "length = 100", problems)
        .and_then(|item| lengths(item, names, problems));
    let vector = VectorFamily {
        name: item.key.clone(),
        components: components?,
    };
    Some((vector, length?))
}
