//! Matrices of couplings: parameters with a number for every two sites of a chain, `"J[i,j]"`.

use std::sync::{Arc, Mutex, PoisonError};

use leafwise_expression::syntax::{INDEX_NAMES, VariablePattern};

use super::error::SceneProblemCause;
use super::field::FieldSpec;
use super::located::Located;
use super::reader::Problems;

/// A number for every two sites.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixSpec {
    /// The key, `J[i,j]`.
    pub key: Located<String>,
    /// The name that formulas use, `J`.
    pub name: Located<String>,
    /// The indices of row and column.
    pub indices: [String; 2],
    /// Where the numbers come from.
    pub field: FieldSpec,
    made: MadeMatrix,
}

/// Numbers row after row.
pub type MatrixNumbers = Arc<[f64]>;

/// The numbers as they were last formed, with the number of sites and the values of parameters, shared by all copies of a
/// document.
#[derive(Clone, Debug, Default)]
struct MadeMatrix(Arc<Mutex<Option<Formed>>>);

#[derive(Debug)]
struct Formed {
    order: usize,
    parameters: Vec<f64>,
    numbers: MatrixNumbers,
}

/// Where the numbers come from decides.
impl PartialEq for MadeMatrix {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl MatrixSpec {
    /// The numbers of so many rows at these values of the parameters: those of the last call where it was for the same.
    ///
    /// # Errors
    /// Those of `form`.
    pub fn numbers<E>(
        &self,
        (order, parameters): (usize, &[f64]),
        form: impl FnOnce() -> Result<Vec<f64>, E>,
    ) -> Result<MatrixNumbers, E> {
        let mut made = self.made.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = &*made
            && last.order == order
            && last.parameters == parameters
        {
            return Ok(Arc::clone(&last.numbers));
        }
        let numbers: MatrixNumbers = form()?.into();
        *made = Some(Formed {
            order,
            parameters: parameters.to_vec(),
            numbers: Arc::clone(&numbers),
        });
        Ok(numbers)
    }
}

/// Parameters of sites of a chain, and those of them that are matrices.
pub(super) fn take_matrices(
    sites: Vec<(Located<String>, FieldSpec)>,
    problems: &mut Problems,
) -> (Vec<(Located<String>, FieldSpec)>, Vec<MatrixSpec>) {
    let (mut of_sites, mut matrices) = (Vec::new(), Vec::<MatrixSpec>::new());
    for (key, field) in sites {
        let pattern = VariablePattern::parse_one(&key.value).ok();
        let Some(pattern) = pattern.filter(|pattern| pattern.axes() == 2) else {
            of_sites.push((key, field));
            continue;
        };
        let indices = pattern.index_names();
        let [row, column] = &indices[..] else {
            refuse(&key, "single entries", problems);
            continue;
        };
        if row.is_empty() || column.is_empty() || pattern.is_shifted() {
            refuse(&key, "a part of its entries", problems);
        } else if row == column {
            refuse(&key, "its diagonal", problems);
        } else if matrices.iter().any(|own| own.name.value == pattern.name()) {
            let name = pattern.name().to_owned();
            problems.push(SceneProblemCause::Duplicate { name }, key.place());
        } else {
            matrices.push(MatrixSpec {
                name: key.clone().map(|_| pattern.name().to_owned()),
                indices: [row, column].map(|index| (*index).to_owned()),
                key,
                field,
                made: MadeMatrix::default(),
            });
        }
    }
    (of_sites, matrices)
}

/// Where sites have names, a matrix is given by two indices that are none of them.
pub(super) fn check_indices(matrices: &[MatrixSpec], problems: &mut Problems) {
    for matrix in matrices {
        let mut indices = matrix.indices.iter();
        if !indices.all(|index| INDEX_NAMES.contains(&index.as_str())) {
            refuse(&matrix.key, "single entries", problems);
        }
    }
}

/// Records a key that does not stand for all entries.
fn refuse(key: &Located<String>, found: &str, problems: &mut Problems) {
    let name = key.value.split('[').next().unwrap_or_default();
    problems.push(
        SceneProblemCause::Shape {
            what: format!("\"{}\"", key.value),
            found: found.to_owned(),
            expected: format!(
                "all of them, by two indices, as \"{name}[i,j]\" = \"if(i == j, 0, 1)\""
            ),
        },
        key.place(),
    );
}
