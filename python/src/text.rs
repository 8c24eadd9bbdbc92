//! Tables of Python as text of a scene.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{
    PyBool, PyBytes, PyDict, PyFloat, PyFrozenSet, PyInt, PyList, PySet, PyString, PyTuple,
};
use toml::{Table, Value};

/// Lists and tables that lie within each other, at most: a scene needs six.
const DEEPEST: usize = 32;

/// A table as TOML; lists may be arrays and tuples.
#[pyfunction]
pub(crate) fn text_of(table: &Bound<'_, PyDict>) -> PyResult<String> {
    let mut table = table_of(table, "", DEEPEST)?;
    let mut inline = Vec::new();
    keep_order(&mut table, &mut inline);
    let mut text =
        toml::to_string(&table).map_err(|error| PyValueError::new_err(error.to_string()))?;
    for (at, value) in inline.iter().enumerate().rev() {
        text = text.replacen(
            &Value::String(stand_in(at)).to_string(),
            &value.to_string(),
            1,
        );
    }
    Ok(text)
}

/// A string in the place of the table with this number.
fn stand_in(number: usize) -> String {
    format!("a table of leafwise.Scene: {number:06}")
}

/// Takes out tables that stand before other values of the same table, to be written in a line in their place. The order of families
/// is that of the state, and TOML's sections stand behind all other values.
fn keep_order(table: &mut Table, inline: &mut Vec<Value>) {
    let last = table.iter().rposition(|(_, value)| !value.is_table());
    for (at, (_, value)) in table.iter_mut().enumerate() {
        match value {
            Value::Table(_) if last.is_some_and(|last| at < last) => {
                let number = stand_in(inline.len());
                inline.push(std::mem::replace(value, Value::String(number)));
            }
            Value::Table(inner) => keep_order(inner, inline),
            _ => {}
        }
    }
}

/// A Python value as TOML on one line, as an override takes it; `key` is what a message calls it.
#[pyfunction]
pub(crate) fn text_of_value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    value_of(value, key, DEEPEST).map(|value| value.to_string())
}

/// One level further down.
fn within(path: &str, depth: usize) -> PyResult<usize> {
    depth.checked_sub(1).ok_or_else(|| {
        let start: String = path.chars().take(60).collect();
        PyTypeError::new_err(format!(
            "{start}…: lists or tables lie within each other more than {DEEPEST} times, or one holds itself"
        ))
    })
}

fn table_of(table: &Bound<'_, PyDict>, path: &str, depth: usize) -> PyResult<Table> {
    let depth = within(path, depth)?;
    let mut found = Table::new();
    for (key, value) in table {
        let Ok(key) = key.extract::<String>() else {
            let place = if path.is_empty() { "a scene" } else { path };
            let kind = key.get_type();
            return Err(PyTypeError::new_err(format!(
                "{place}: keys are strings, not {}",
                match key.is_instance_of::<PyInt>() {
                    true => key.to_string(),
                    false => kind.name()?.to_string(),
                }
            )));
        };
        let path = match path {
            "" => key.clone(),
            path => format!("{path}.{key}"),
        };
        found.insert(key, value_of(&value, &path, depth)?);
    }
    Ok(found)
}

fn value_of(value: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<Value> {
    if let Ok(table) = value.cast::<PyDict>() {
        return table_of(table, path, depth).map(Value::Table);
    }
    if value.is_instance_of::<PyBool>() {
        return value.extract().map(Value::Boolean);
    }
    if value.is_instance_of::<PyString>() {
        return value.extract().map(Value::String);
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract().map(Value::Float);
    }
    if value.is_instance_of::<PyInt>() {
        return value.extract().map(Value::Integer).map_err(|_| {
            PyValueError::new_err(format!(
                "{path} is a whole number beyond 2^63: give it as a float"
            ))
        });
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        return list_of(value, path, depth);
    }
    // An array, a number of one, a series with names: as lists, numbers and tables of Python.
    let is_array = ["dtype", "tolist", "__array__", "keys"];
    if is_array
        .iter()
        .any(|name| value.hasattr(*name).unwrap_or(false))
    {
        let arrays = value.py().import("leafwise._arrays")?;
        let plain = arrays.call_method1("plain", (path, value))?;
        return value_of(&plain, path, within(path, depth)?);
    }
    // A set has no order, and bytes are no numbers.
    let has_none = value.is_instance_of::<PySet>()
        || value.is_instance_of::<PyFrozenSet>()
        || value.is_instance_of::<PyBytes>();
    if !has_none && value.try_iter().is_ok() {
        return list_of(value, path, depth);
    }
    let kind = value.get_type();
    let kind = kind.name()?;
    Err(PyTypeError::new_err(format!(
        "{path}: a scene holds numbers, strings, booleans, lists and tables, not {kind}"
    )))
}

fn list_of(value: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<Value> {
    let depth = within(path, depth)?;
    let items = value.try_iter()?.enumerate();
    let items = items.map(|(at, item)| value_of(&item?, &format!("{path}[{at}]"), depth));
    items.collect::<PyResult<_>>().map(Value::Array)
}

/// The table `name` of a text in TOML, with or without its heading, as Python's.
#[pyfunction]
pub(crate) fn table_of_text<'py>(
    py: Python<'py>,
    name: &str,
    text: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let table = text.parse::<Table>();
    let table = table.map_err(|error| PyValueError::new_err(format!("{name}: {error}")))?;
    let own = match table.get(name) {
        Some(Value::Table(own)) => own.clone(),
        _ => table,
    };
    python_of(py, &Value::Table(own))
}

fn python_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Table(table) => {
            let found = PyDict::new(py);
            for (key, value) in table {
                found.set_item(key, python_of(py, value)?)?;
            }
            found.into_any()
        }
        Value::Array(items) => {
            let items = items.iter().map(|item| python_of(py, item));
            PyList::new(py, items.collect::<PyResult<Vec<_>>>()?)?.into_any()
        }
        Value::Boolean(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Integer(value) => value.into_pyobject(py)?.into_any(),
        Value::Float(value) => value.into_pyobject(py)?.into_any(),
        Value::String(value) => value.into_pyobject(py)?.into_any(),
        Value::Datetime(value) => value.to_string().into_pyobject(py)?.into_any(),
    })
}
