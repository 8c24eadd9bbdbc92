//! `variables = ["q", "p"]`, or vectors by their numbers of components: `variables = { r = 3, p = 3 }`.

use super::error::SceneProblemCause;
use super::located::Located;
use super::reader::{Item, Problems};
use super::system_section::VectorFamily;

/// Names of the components of a vector that tells their number alone.
pub(super) const COMPONENTS: [&str; 3] = ["x", "y", "z"];

/// Single variables, and the vectors that some of them are components of.
#[derive(Default)]
pub(super) struct Variables {
    pub names: Vec<Located<String>>,
    pub vectors: Vec<VectorFamily>,
}

/// Reads the value of `variables`.
pub(super) fn read_variables(item: &Item<'_>, problems: &mut Problems) -> Option<Variables> {
    if !item.is_table() {
        let names = item.list_of(
            "a list of names, or a table of vectors",
            problems,
            Item::string,
        )?;
        return Some(Variables {
            names,
            vectors: Vec::new(),
        });
    }
    let table = item.table(&item.title, "a table of vectors", problems)?;
    let mut variables = Variables::default();
    let mut is_whole = true;
    for entry in &table.items {
        let Some(components) = components(entry, problems) else {
            is_whole = false;
            continue;
        };
        // A vector of one component is a variable.
        if components.is_empty() {
            variables.names.push(entry.key.clone());
            continue;
        }
        let vector = VectorFamily {
            name: entry.key.clone(),
            components,
        };
        for component in &vector.components {
            let name = component.clone().map(|name| vector.family(&name));
            variables.names.push(name);
        }
        variables.vectors.push(vector);
    }
    is_whole.then_some(variables)
}

/// The names of a vector's components; none of a single variable.
fn components(item: &Item<'_>, problems: &mut Problems) -> Option<Vec<Located<String>>> {
    if item.is_list() {
        let names = item.list_of("a list of names of components", problems, Item::string)?;
        if names.is_empty() {
            let cause = SceneProblemCause::Shape {
                what: item.title.clone(),
                found: "no component".to_owned(),
                expected: "names of components, or how many there are".to_owned(),
            };
            problems.push(cause, item.place());
            return None;
        }
        let letters = names
            .iter()
            .map(|name| COMPONENTS.iter().position(|c| *c == name.value));
        let letters: Option<Vec<usize>> = letters.collect();
        if letters.is_some_and(|letters| !letters.is_sorted()) {
            let cause = SceneProblemCause::Shape {
                what: item.title.clone(),
                found: "x, y and z in another order".to_owned(),
                expected: "them in the order x, y, z, in which vectors are multiplied".to_owned(),
            };
            problems.push(cause, item.place());
            return None;
        }
        return Some(names);
    }
    let most = COMPONENTS.len() as u64;
    let count = item.whole_in(1, most, problems)?.value as usize;
    let named = COMPONENTS[..count].iter().filter(|_| count > 1);
    Some(
        named
            .map(|name| Located::new((*name).to_owned(), item.place()))
            .collect(),
    )
}
