//! `lie-algebra = …`: a Lie algebra by its name or its structure constants, and the vectors that it acts on.

use super::error::SceneProblemCause;
use super::located::{Located, Number};
use super::reader::{Item, Problems};
use super::system_schema::LIE_ALGEBRA;

/// A linear bracket {x_i, x_j} = −Σ_k c_ij^k x_k, the paper's sign.
#[derive(Clone, Debug, PartialEq)]
pub struct LieAlgebraSpec {
    /// The algebra 𝔤.
    pub algebra: AlgebraSpec,
    /// ρ(e_1), ρ(e_2), …, each by its rows, of the semidirect product 𝔤 ⋉ V: [e_i, v_a] = Σ_b ρ(e_i)_ba v_b.
    pub representation: Option<Located<Vec<Located<Matrix>>>>,
}

/// Rows of a square matrix.
pub type Matrix = Vec<Vec<Located<Number>>>;

/// A Lie algebra.
#[derive(Clone, Debug, PartialEq)]
pub enum AlgebraSpec {
    /// One that is known by name.
    Named(Located<String>),
    /// One by its structure constants.
    Structure(Located<Vec<Located<StructureConstant>>>),
}

/// c in [e_i, e_j] = … + c e_k + ….
#[derive(Clone, Debug, PartialEq)]
pub struct StructureConstant {
    /// i, j and k, from 1 on.
    pub indices: [Located<u64>; 3],
    /// c.
    pub value: Located<Number>,
}

/// Reads the value of `lie-algebra`.
pub(super) fn read_lie_algebra(item: &Item<'_>, problems: &mut Problems) -> Option<LieAlgebraSpec> {
    if !item.is_table() {
        if !item.is_string() {
            item.wrong_type(
                "a name in quotes, or a table with name or structure",
                problems,
            );
            return None;
        }
        let algebra = AlgebraSpec::Named(item.string(problems)?);
        return Some(LieAlgebraSpec {
            algebra,
            representation: None,
        });
    }
    let table = item.table("lie-algebra", "a table", problems)?;
    table.only(&LIE_ALGEBRA, problems);
    let algebra = match (table.get("name"), table.get("structure")) {
        // Refused beside each other.
        (Some(_), Some(_)) => None,
        (None, Some(structure)) => {
            let entries = structure.list("a list of [i, j, k, c]", problems)?;
            // Counted from 1, as the e_i are.
            let constants = (1_usize..).zip(&entries);
            let constants: Vec<_> = constants
                .map(|(number, entry)| constant(number, entry, problems))
                .collect();
            let list: Option<Vec<_>> = constants.into_iter().collect();
            list.map(|list| AlgebraSpec::Structure(Located::new(list, structure.place())))
        }
        (_, None) => table
            .require(
                "name",
                "name = \"so3\", or structure = [[1, 2, 3, 1], …] for [e1, e2] = e3 + …",
                problems,
            )
            .and_then(|name| name.string(problems))
            .map(AlgebraSpec::Named),
    };
    let representation = match table.get("representation") {
        None => Some(None),
        Some(item) => item
            .list_of(
                "a list of matrices, one for each e_i",
                problems,
                |each, problems| Some(Located::new(each.square_matrix(problems)?, each.place())),
            )
            .map(|matrices| Some(Located::new(matrices, item.place()))),
    };
    Some(LieAlgebraSpec {
        algebra: algebra?,
        representation: representation?,
    })
}

/// `[i, j, k, c]`, the entry of this number.
fn constant(
    number: usize,
    item: &Item<'_>,
    problems: &mut Problems,
) -> Option<Located<StructureConstant>> {
    let mut item = item.clone();
    item.title = format!("entry {number} of structure");
    let mut entries = item.list("[i, j, k, c]", problems)?;
    for (entry, name) in entries.iter_mut().zip(["i", "j", "k", "c"]) {
        entry.title = format!("{name} in entry {number} of structure");
    }
    let [i, j, k, c] = &entries[..] else {
        problems.push(
            SceneProblemCause::Shape {
                what: item.title.clone(),
                found: format!("{} entries", entries.len()),
                expected: "four: [i, j, k, c] for [e_i, e_j] = … + c e_k + …".to_owned(),
            },
            item.place(),
        );
        return None;
    };
    let indices = [i, j, k].map(|index| index.whole(1, problems));
    let value = c.constant(problems);
    let [Some(i), Some(j), Some(k)] = indices else {
        return None;
    };
    let constant = StructureConstant {
        indices: [i, j, k],
        value: value?,
    };
    Some(Located::new(constant, item.place()))
}
