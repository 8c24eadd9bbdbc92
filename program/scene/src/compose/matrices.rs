//! The matrices of couplings of a scene.

use leafwise_core::NumberArray;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::names::{parse, refusal};
use crate::document::{FieldSpec, Located, MatrixNumbers, MatrixSpec, Place, SceneDocument};
use crate::npy::read_npy;
use crate::table::read_rows;

/// The matrices with as many rows as there are sites, in the order of the text. Formulas of entries may use the names of
/// `scope`.
///
/// # Errors
/// A file that cannot be read, numbers of another shape or that are not finite, a formula without a value, underlined in
/// the scene.
pub(super) fn matrices(
    document: &SceneDocument,
    scope: &Scope,
) -> Result<Vec<(String, MatrixNumbers)>, Refusal> {
    let parameters = document.system.parameters.iter();
    let parameters: Vec<f64> = parameters.map(|(_, value)| value.value.value).collect();
    let order = order(document);
    let all = document.system.matrices.iter().map(|matrix| {
        let numbers = matrix.numbers((order, &parameters), || {
            form(document, matrix, scope, (order, &parameters))
        })?;
        Ok((matrix.name.value.clone(), numbers))
    });
    all.collect()
}

/// The number of rows: that of the sites of the longest family.
pub(super) fn order(document: &SceneDocument) -> usize {
    let families = document.system.families.iter();
    families.map(|(_, length)| length.value).max().unwrap_or(0)
}

fn form(
    document: &SceneDocument,
    matrix: &MatrixSpec,
    scope: &Scope,
    (order, parameters): (usize, &[f64]),
) -> Result<Vec<f64>, Refusal> {
    let (numbers, place) = match &matrix.field {
        FieldSpec::Formula(formula) => {
            let parsed = parse(document, formula)?;
            let [row, column] = &matrix.indices;
            let numbers = parsed
                .matrix(scope, parameters, ([row, column], order))
                .map_err(|error| refusal(document, formula, &error))?;
            (
                numbers,
                document.place_in_formula(formula, 0..formula.value.len()),
            )
        }
        FieldSpec::Numbers(numbers, place) => {
            let array = NumberArray {
                shape: vec![numbers.len()],
                numbers: numbers.iter().map(|number| number.value.value).collect(),
            };
            (
                shaped(document, matrix, place, array, order)?,
                place.clone(),
            )
        }
        FieldSpec::Rows(array, place) => {
            let array = NumberArray::clone(array);
            (
                shaped(document, matrix, place, array, order)?,
                place.clone(),
            )
        }
        FieldSpec::File { file, column } => {
            if let Some(column) = column {
                return Err(refuse(
                    document,
                    &column.place(),
                    format!(
                        "`{}` is a matrix, and a column has one number for each site",
                        matrix.name.value
                    ),
                ));
            }
            let array = read(document, file)?;
            (
                shaped(document, matrix, &file.place(), array, order)?,
                file.place(),
            )
        }
    };
    let wrong = numbers.iter().position(|number| !number.is_finite());
    match wrong {
        None => Ok(numbers),
        Some(at) => {
            let name = &matrix.name.value;
            let (row, column) = (at / order, at % order);
            let message = format!(
                "{name}[{row},{column}] is {:?}, not a finite number",
                numbers[at]
            );
            Err(refuse(document, &place, message))
        }
    }
}

/// The grid of a file beside the scene.
fn read(document: &SceneDocument, file: &Located<String>) -> Result<NumberArray, Refusal> {
    let path = document.directory().join(&file.value);
    let end = path.extension();
    let is_npy = end.is_some_and(|end| end.eq_ignore_ascii_case("npy"));
    let array = match is_npy {
        true => read_npy(&path),
        false => read_rows(&path),
    };
    array.map_err(|reason| refuse(document, &file.place(), reason))
}

/// The numbers of an array of so many rows and columns.
fn shaped(
    document: &SceneDocument,
    matrix: &MatrixSpec,
    place: &Place,
    array: NumberArray,
    order: usize,
) -> Result<Vec<f64>, Refusal> {
    match array.shape == [order, order] {
        true => Ok(array.numbers),
        false => Err(refuse(
            document,
            place,
            format!(
                "the numbers of `{}` have the shape {:?}, and there are {order} sites: [{order}, {order}] is needed",
                matrix.name.value, array.shape
            ),
        )),
    }
}

fn refuse(document: &SceneDocument, place: &Place, message: String) -> Refusal {
    let help = "one finite number for every two sites: a formula of both indices, as \"if(i == j, 0, 1/N)\", rows of numbers, \
                or a file beside the scene, an array of NumPy's (.npy) or a grid of CSV or JSON";
    Box::new(document.diagnostic(place, message, "here", Some(help.to_owned())))
}
