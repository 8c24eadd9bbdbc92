//! Tables of numbers that formulas call as functions.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use leafwise_core::NumberArray;
use leafwise_core::Registry;
use leafwise_expression::table::{
    HIGHEST_DEGREE, MOST_AXES, TableAxis, TableFunction, USUAL_DEGREE,
};

use super::error::SceneProblemCause;
use super::located::{Located, Number, Place};
use super::reader::{Item, Problems};
use super::suggest::nearest;
use super::system_schema::LOOKUP;
use crate::grid::{GridAxis, read_nodes};
use crate::npy::read_npy;

/// A table: where its numbers are, and what its axes are.
#[derive(Clone, Debug, PartialEq)]
pub struct TableSpec {
    /// The file of its numbers.
    pub file: Option<Located<String>>,
    /// Its column, where it has one axis and a file of several.
    pub column: Option<Located<String>>,
    /// The numbers, where they stand in the scene.
    pub values: Option<Arc<NumberArray>>,
    /// The numbers, where they are given in the place of those of the scene or of a file.
    pub numbers: Option<Arc<NumberArray>>,
    /// Names of the axes with their ends.
    pub axes: Vec<(Located<String>, [Located<Number>; 2])>,
    /// The axes that are periods.
    pub periodic: Vec<Located<String>>,
    /// The degree of its polynomials.
    pub degree: u8,
    /// The place of all of it.
    pub place: Place,
    function: MadeFunction,
}

/// The spline, made once for all copies of a document.
#[derive(Clone, Debug, Default)]
struct MadeFunction(Arc<OnceLock<Result<TableFunction, (Place, String)>>>);

/// The numbers decide: of equal tables the splines are.
impl PartialEq for MadeFunction {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl TableSpec {
    /// The function that formulas call `name`, of files beside the scene.
    ///
    /// # Errors
    /// What is wrong with its file or its numbers, and the place to underline.
    pub fn function(&self, name: &str, directory: &Path) -> Result<TableFunction, (Place, String)> {
        let made = self.function.0.get_or_init(|| self.make(name, directory));
        made.clone()
    }

    fn make(&self, name: &str, directory: &Path) -> Result<TableFunction, (Place, String)> {
        let place = match &self.file {
            Some(file) if self.numbers.is_none() => file.place(),
            _ => self.place.clone(),
        };
        let array = self
            .array(name, directory)
            .map_err(|reason| (place.clone(), reason))?;
        if array.shape.len() != self.axes.len() {
            let reason = format!(
                "the numbers of `{name}` have the shape {:?}, and the table has {}: one length for each axis is needed",
                array.shape,
                match self.axes.len() {
                    1 => "1 axis".to_owned(),
                    axes => format!("{axes} axes"),
                }
            );
            return Err((place, reason));
        }
        let axes = self.axes.iter().zip(&array.shape);
        let axes = axes.map(|((axis, [first, last]), nodes)| TableAxis {
            name: axis.value.clone(),
            first: first.value.value,
            last: last.value.value,
            nodes: *nodes,
            is_periodic: self.is_periodic(axis),
        });
        TableFunction::new(name, axes.collect(), self.degree, &array.numbers).map_err(|error| {
            // As many columns as a list of places and values has.
            let is_list = self.axes.len() == 2 && array.shape[1] == 3 && self.file.is_some();
            let names: Vec<&str> = self.axes.iter().map(|(axis, _)| axis.value.as_str()).collect();
            let list = match is_list {
                true => format!(
                    "; is it a list of {} and a value in each row? Then its first line is {},{name}",
                    names.join(", "),
                    names.join(",")
                ),
                false => String::new(),
            };
            (place, format!("the table `{name}`: {error}{list}"))
        })
    }

    fn grid_axes(&self) -> Vec<GridAxis<'_>> {
        let axes = self.axes.iter();
        axes.map(|(name, [first, last])| GridAxis {
            name: &name.value,
            ends: [first.value.value, last.value.value],
            is_periodic: self.is_periodic(name),
        })
        .collect()
    }

    fn is_periodic(&self, axis: &Located<String>) -> bool {
        self.periodic.iter().any(|own| own.value == axis.value)
    }

    fn array(&self, name: &str, directory: &Path) -> Result<Arc<NumberArray>, String> {
        if let Some(numbers) = self.numbers.as_ref().or(self.values.as_ref()) {
            return Ok(Arc::clone(numbers));
        }
        let Some(file) = &self.file else {
            return Err(format!("the table `{name}` has no numbers"));
        };
        let path = directory.join(&file.value);
        let is_npy = path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("npy"));
        let column = self.column.as_ref().map(|column| column.value.as_str());
        let array = match (is_npy, column) {
            (true, Some(column)) if self.axes.len() > 1 => {
                return Err(format!(
                    "{}: an array has no column `{column}`; leave `column` out",
                    path.display()
                ));
            }
            (true, _) => read_npy(&path)?,
            (false, _) => read_nodes(&path, &self.grid_axes(), column)?,
        };
        Ok(Arc::new(array))
    }
}

/// Tables by their names; of those that the registry has arrays for the numbers are these.
pub(super) fn read_tables(
    item: Option<&Item<'_>>,
    registry: &Registry,
    problems: &mut Problems,
) -> Option<Vec<(Located<String>, TableSpec)>> {
    let Some(item) = item else {
        return Some(Vec::new());
    };
    let tables = item.pairs("a table of tables", problems, read_table)?;
    let with_arrays = tables.into_iter().map(|(name, mut table)| {
        table.numbers = registry.array(&name.value);
        (name, table)
    });
    Some(with_arrays.collect())
}

/// `{ file = "psi.npy", axes = { R = [0.8, 1.2], Z = [-0.2, 0.2] }, degree = 5, periodic = [] }`.
fn read_table(item: &Item<'_>, problems: &mut Problems) -> Option<TableSpec> {
    let table = item.table(&item.title, "a table with `file` and `axes`", problems)?;
    table.only(&LOOKUP, problems);
    let text = |key: &str, problems: &mut Problems| match table.get(key) {
        Some(item) => item.string(problems).map(Some),
        None => Some(None),
    };
    let (file, column) = (text("file", problems), text("column", problems));
    let values = match table.get("values") {
        Some(item) => values(item, problems).map(|numbers| Some(Arc::new(numbers))),
        None => Some(None),
    };
    let axes = table
        .require(
            "axes",
            "axes = { R = [0.8, 1.2], Z = [-0.2, 0.2] }",
            problems,
        )
        .and_then(|item| {
            let axes = item.pairs("a table of ends, { x = [0, 1] }", problems, ends)?;
            if (1..=MOST_AXES).contains(&axes.len()) {
                return Some(axes);
            }
            let cause = SceneProblemCause::Shape {
                what: "axes".to_owned(),
                found: format!("{} axes", axes.len()),
                expected: format!("1 to {MOST_AXES}"),
            };
            problems.push(cause, item.place());
            None
        });
    let degree = match table.get("degree") {
        Some(item) => item
            .whole_in(1, HIGHEST_DEGREE.into(), problems)
            .map(|degree| degree.value),
        None => Some(USUAL_DEGREE.into()),
    };
    let periodic = match table.get("periodic") {
        Some(item) => item.list_of("a list of axes", problems, Item::string),
        None => Some(Vec::new()),
    };
    let (axes, periodic) = (axes?, periodic?);
    for name in &periodic {
        let known = axes.iter().map(|(axis, _)| axis.value.as_str());
        if known.clone().any(|axis| axis == name.value) {
            continue;
        }
        let cause = SceneProblemCause::UnknownName {
            kind: "axis of this table",
            name: name.value.clone(),
            nearest: nearest(&name.value, known.clone()),
            valid: known.map(str::to_owned).collect(),
        };
        problems.push(cause, name.place());
    }
    let (file, column) = (file?, column?);
    Some(TableSpec {
        file,
        column,
        values: values?,
        numbers: None,
        axes,
        periodic,
        degree: degree? as u8,
        place: item.place(),
        function: MadeFunction::default(),
    })
}

/// A list of numbers, of lists of numbers, or of lists of such lists.
pub(super) fn values(item: &Item<'_>, problems: &mut Problems) -> Option<NumberArray> {
    let expected = "numbers: a list for one axis, a list of rows for two";
    let entries = item.list(expected, problems)?;
    if !entries.iter().any(Item::is_list) {
        let numbers: Vec<_> = entries.iter().map(|entry| entry.number(problems)).collect();
        let numbers: Option<Vec<Located<Number>>> = numbers.into_iter().collect();
        let numbers: Vec<f64> = numbers?.iter().map(|number| number.value.value).collect();
        return Some(NumberArray {
            shape: vec![numbers.len()],
            numbers,
        });
    }
    let rows: Vec<_> = entries
        .iter()
        .map(|entry| values(entry, problems))
        .collect();
    let rows: Option<Vec<NumberArray>> = rows.into_iter().collect();
    let rows = rows?;
    let own = &rows[0].shape;
    if let Some(other) = rows.iter().position(|row| row.shape != *own) {
        let cause = SceneProblemCause::Shape {
            what: entries[other].title.clone(),
            found: format!("the shape {:?}", rows[other].shape),
            expected: format!("{own:?}, that of the rows before it"),
        };
        problems.push(cause, entries[other].place());
        return None;
    }
    Some(NumberArray {
        shape: std::iter::once(rows.len()).chain(own.clone()).collect(),
        numbers: rows.iter().flat_map(|row| row.numbers.clone()).collect(),
    })
}

/// The first and the last node.
fn ends(item: &Item<'_>, problems: &mut Problems) -> Option<[Located<Number>; 2]> {
    let numbers = item.list_of("its two ends, [0, 1]", problems, Item::constant)?;
    let found = numbers.len();
    let ends: Result<[Located<Number>; 2], _> = numbers.try_into();
    match ends {
        Ok(ends) if ends[0].value.value < ends[1].value.value => Some(ends),
        Ok([first, last]) => {
            let cause = SceneProblemCause::OutOfRange {
                key: item.title.clone(),
                value: format!("[{}, {}]", first.value.literal, last.value.literal),
                allowed: "two ends, the first below the last".to_owned(),
            };
            problems.push(cause, item.place());
            None
        }
        Err(_) => {
            let cause = SceneProblemCause::Shape {
                what: item.title.clone(),
                found: format!("{found} numbers"),
                expected: "two, the first and the last node".to_owned(),
            };
            problems.push(cause, item.place());
            None
        }
    }
}
