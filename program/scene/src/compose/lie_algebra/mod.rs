//! Linear brackets {x_i, x_j} = −Σ_k c_ij^k x_k, the paper's sign, of algebras by name, by structure constants, and
//! with the vectors that they act on.

mod known;

use std::collections::BTreeMap;

use leafwise_expression::{Expression, Rational};

pub use known::{LIE_ALGEBRAS, LieAlgebra, StructureEntry};

use super::Refusal;
use super::names::exact;
use crate::document::{
    AlgebraSpec, LieAlgebraSpec, Located, Matrix, Place, SceneDocument, StructureConstant, nearest,
};

/// c_ij^k for i < j that are not zero, indices from 0 on.
type Constants = BTreeMap<(usize, usize, usize), Rational>;

/// The entries of a bracket over so many variables: those of the algebra, then those of the vectors.
pub(super) fn entries(
    document: &SceneDocument,
    spec: &LieAlgebraSpec,
    names: &[String],
) -> Result<BTreeMap<(usize, usize), Expression>, Refusal> {
    let vectors = match &spec.representation {
        None => 0,
        Some(matrices) => size(document, matrices)?,
    };
    let d = names.len().saturating_sub(vectors);
    let constants = match &spec.algebra {
        AlgebraSpec::Named(name) => of_named(named(document, name, vectors, names.len())?),
        AlgebraSpec::Structure(list) => of_structure(document, list, d)?,
    };
    let mut sums: BTreeMap<(usize, usize), Vec<Expression>> = BTreeMap::new();
    for ((i, j, k), c) in &constants {
        sums.entry((*i, *j)).or_default().push(scaled(-c, *k));
    }
    if let Some(matrices) = &spec.representation {
        let rho = representation(document, matrices, d, &constants)?;
        for (i, matrix) in rho.iter().enumerate() {
            for (b, row) in matrix.iter().enumerate() {
                for (a, entry) in row.iter().enumerate().filter(|(_, entry)| !entry.is_zero()) {
                    let sum = sums.entry((i, d + a)).or_default();
                    sum.push(scaled(-entry, d + b));
                }
            }
        }
    }
    let entries = sums.into_iter();
    Ok(entries
        .map(|(at, sum)| (at, Expression::Sum(sum)))
        .collect())
}

fn scaled(coefficient: Rational, variable: usize) -> Expression {
    Expression::Product(vec![
        Expression::Constant(coefficient),
        Expression::Variable(variable),
    ])
}

fn refused(
    document: &SceneDocument,
    place: &Place,
    message: String,
    label: impl Into<String>,
    help: Option<String>,
) -> Refusal {
    Box::new(document.diagnostic(place, message, label, help))
}

/// The algebra of a name, where it fits so many variables beside the vectors.
fn named(
    document: &SceneDocument,
    name: &Located<String>,
    vectors: usize,
    variables: usize,
) -> Result<&'static LieAlgebra, Refusal> {
    let place = document.place_in_formula(name, 0..name.value.len());
    let Some(algebra) = LieAlgebra::find(&name.value) else {
        let known: Vec<&str> = LIE_ALGEBRAS.iter().map(|algebra| algebra.name).collect();
        let help = match nearest(&name.value, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known: {}; any other by `structure`", known.join(", ")),
        };
        let message = format!("unknown Lie algebra `{}`", name.value);
        return Err(refused(document, &place, message, "not known", Some(help)));
    };
    let d = algebra.dimension();
    if d + vectors == variables {
        return Ok(algebra);
    }
    let acts = match vectors {
        0 => String::new(),
        n => format!(", acts on {n} coordinates of vectors"),
    };
    let mut coordinates: Vec<String> = (algebra.coordinates.iter())
        .map(|name| format!("\"{name}\""))
        .collect();
    coordinates.extend((1..=vectors).map(|a| format!("\"v{a}\"")));
    let (noun, who) = match document.system.vectors.is_empty() {
        true => ("variables", "this scene has"),
        false => ("components", "the vectors have"),
    };
    Err(refused(
        document,
        &place,
        format!(
            "`{}` has dimension {d}{acts}, and {who} {variables} {noun}",
            algebra.name
        ),
        format!("needs {} {noun}", d + vectors),
        Some(format!(
            "for example: {noun} = [{}]",
            coordinates.join(", ")
        )),
    ))
}

fn of_named(algebra: &LieAlgebra) -> Constants {
    let mut constants = Constants::new();
    for &(i, j, terms) in algebra.bracket {
        // The table is of {x_i, x_j} = −Σ c_ij^k x_k.
        let sign = if i < j { -1 } else { 1 };
        for &(coefficient, k) in terms {
            let value = Rational::from_integer(sign * coefficient);
            constants.insert((i.min(j), i.max(j), k), value);
        }
    }
    constants
}

fn of_structure(
    document: &SceneDocument,
    list: &Located<Vec<Located<StructureConstant>>>,
    d: usize,
) -> Result<Constants, Refusal> {
    let mut constants = Constants::new();
    for constant in &list.value {
        let StructureConstant { indices, value } = &constant.value;
        for index in indices {
            if index.value > d as u64 {
                return Err(refused(
                    document,
                    &index.place(),
                    format!("there is no e{} among {d}", index.value),
                    "an index from 1 on",
                    Some("the algebra has as many e_i as the scene has variables, the vectors of `representation` apart".into()),
                ));
            }
        }
        let [i, j, k] = indices.each_ref().map(|index| index.value as usize - 1);
        let c = exact(document, value)?;
        if i == j {
            if c.is_zero() {
                continue;
            }
            return Err(refused(
                document,
                &constant.place(),
                format!("[e{0}, e{0}] is not zero", i + 1),
                "a bracket is antisymmetric",
                Some("remove this entry".into()),
            ));
        }
        let (at, c) = if i < j {
            ((i, j, k), c)
        } else {
            ((j, i, k), -c)
        };
        let known = constants.entry(at).or_insert_with(|| c.clone());
        if *known != c {
            let (i, j, k) = (at.0 + 1, at.1 + 1, at.2 + 1);
            return Err(refused(
                document,
                &constant.place(),
                format!("[e{i}, e{j}] has two different coefficients of e{k}: {known} and {c}"),
                "contradicts an earlier entry",
                Some("write each triple once: antisymmetry fills in the other".into()),
            ));
        }
    }
    constants.retain(|_, c| !c.is_zero());
    Ok(constants)
}

/// How many rows the matrices of a representation have.
fn size(
    document: &SceneDocument,
    matrices: &Located<Vec<Located<Matrix>>>,
) -> Result<usize, Refusal> {
    let mut sizes = matrices.value.iter().map(|matrix| matrix.value.len());
    let first = sizes.next().unwrap_or(0);
    match matrices
        .value
        .iter()
        .find(|matrix| matrix.value.len() != first)
    {
        None => Ok(first),
        Some(other) => Err(refused(
            document,
            &other.place(),
            format!(
                "this matrix has {} rows, and the first has {first}",
                other.value.len()
            ),
            "all act on the same vectors",
            None,
        )),
    }
}

/// ρ(e_1), …, ρ(e_d), with ρ([e_i, e_j]) = [ρ(e_i), ρ(e_j)].
fn representation(
    document: &SceneDocument,
    matrices: &Located<Vec<Located<Matrix>>>,
    d: usize,
    constants: &Constants,
) -> Result<Vec<Vec<Vec<Rational>>>, Refusal> {
    if matrices.value.len() != d {
        return Err(refused(
            document,
            &matrices.place(),
            format!(
                "{} matrices for an algebra of dimension {d}",
                matrices.value.len()
            ),
            "one matrix for each e_i",
            None,
        ));
    }
    let read = |matrix: &Located<Matrix>| -> Result<Vec<Vec<Rational>>, Refusal> {
        let rows = matrix.value.iter();
        rows.map(|row| row.iter().map(|entry| exact(document, entry)).collect())
            .collect()
    };
    let rho: Vec<Vec<Vec<Rational>>> = matrices.value.iter().map(read).collect::<Result<_, _>>()?;
    let n = rho.first().map_or(0, Vec::len);
    for i in 0..d {
        for j in i + 1..d {
            for a in 0..n {
                for b in 0..n {
                    let product = |left: usize, right: usize| {
                        (0..n).fold(Rational::zero(), |sum, m| {
                            &sum + &(&rho[left][a][m] * &rho[right][m][b])
                        })
                    };
                    let commutator = &product(i, j) - &product(j, i);
                    let image =
                        (0..d).fold(Rational::zero(), |sum, k| match constants.get(&(i, j, k)) {
                            None => sum,
                            Some(c) => &sum + &(c * &rho[k][a][b]),
                        });
                    if image != commutator {
                        let (i, j, a, b) = (i + 1, j + 1, a + 1, b + 1);
                        return Err(refused(
                            document,
                            &matrices.place(),
                            format!(
                                "this is not a representation: in row {a}, column {b} the image of [e{i}, e{j}] has {image}, and \
                                 the commutator of the images of e{i} and e{j} has {commutator}"
                            ),
                            "the commutators of these matrices are not those of the algebra",
                            None,
                        ));
                    }
                }
            }
        }
    }
    Ok(rho)
}
