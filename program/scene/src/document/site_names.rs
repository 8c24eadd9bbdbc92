//! Names of the sites of a chain, such as bodies: `families = { q = ["Sun", "Earth"] }`.

use std::collections::HashSet;

use leafwise_expression::syntax::{INDEX_NAMES, Scope, SiteNames};

use super::error::SceneProblemCause;
use super::located::Located;
use super::matrices::check_indices;
use super::reader::Problems;
use super::system_section::SystemSection;

/// Names that one family gives to its sites.
pub(super) type NamedSites = Located<Vec<Located<String>>>;

/// Takes the names that families give to the sites of a chain, which all of its families share.
pub(super) fn name_sites(
    system: &mut SystemSection,
    lists: Vec<NamedSites>,
    problems: &mut Problems,
) {
    let mut lists = lists.into_iter();
    let Some(first) = lists.next() else {
        return;
    };
    let texts = |list: &NamedSites| -> Vec<String> {
        list.value.iter().map(|name| name.value.clone()).collect()
    };
    let names = texts(&first);
    if let Some(other) = lists.find(|other| texts(other) != names) {
        problems.push(
            SceneProblemCause::Shape {
                what: "this list of names".to_owned(),
                found: format!("{:?}", texts(&other)),
                expected: format!(
                    "{names:?}, as before: an index counts the sites of all families"
                ),
            },
            other.place(),
        );
        return;
    }
    let mut families = system.families.iter();
    if let Some((family, length)) = families.find(|(_, length)| length.value > names.len()) {
        problems.push(
            SceneProblemCause::Shape {
                what: format!("the family `{}`", family.value),
                found: format!("{} sites", length.value),
                expected: format!(
                    "at most {}, as there are names: give every site one, or none",
                    names.len()
                ),
            },
            length.place(),
        );
        return;
    }
    check_each(&first.value, problems);
    check_indices(&system.matrices, problems);
    system.site_names = SiteNames::new(names);
}

/// Every name is one that brackets can hold, and stands once.
fn check_each(names: &[Located<String>], problems: &mut Problems) {
    let mut seen: HashSet<&str> = HashSet::new();
    for name in names {
        let is_index = INDEX_NAMES.contains(&name.value.as_str());
        let reason = match Scope::check_name(&name.value) {
            _ if name.value.contains('.') => Some("a name of a site has no point"),
            Ok(()) if is_index => Some("i, j, k, l, m and n are indices"),
            Ok(()) => None,
            Err(_) => Some(
                "a name is a letter followed by letters, digits and underscores, and no function of formulas",
            ),
        };
        let cause = match reason {
            Some(reason) => SceneProblemCause::InvalidName {
                kind: "site",
                name: name.value.clone(),
                reason,
            },
            None if !seen.insert(&name.value) => SceneProblemCause::Duplicate {
                name: name.value.clone(),
            },
            None => continue,
        };
        problems.push(cause, name.place());
    }
}
