//! Tables of Python as text of a scene.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use toml::{Table, Value};

/// A table as TOML; lists may be arrays and tuples.
#[pyfunction]
pub(crate) fn text_of(table: &Bound<'_, PyDict>) -> PyResult<String> {
    let table = table_of(table, "")?;
    toml::to_string(&table).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// A Python value as TOML on one line, as an override takes it.
#[pyfunction]
pub(crate) fn text_of_value(value: &Bound<'_, PyAny>) -> PyResult<String> {
    value_of(value, "the value").map(|value| value.to_string())
}

fn table_of(table: &Bound<'_, PyDict>, path: &str) -> PyResult<Table> {
    let mut found = Table::new();
    for (key, value) in table {
        let Ok(key) = key.extract::<String>() else {
            let place = if path.is_empty() { "a scene" } else { path };
            return Err(PyTypeError::new_err(format!(
                "{place}: keys are strings, not {key}"
            )));
        };
        let path = match path {
            "" => key.clone(),
            path => format!("{path}.{key}"),
        };
        found.insert(key, value_of(&value, &path)?);
    }
    Ok(found)
}

fn value_of(value: &Bound<'_, PyAny>, path: &str) -> PyResult<Value> {
    if let Ok(table) = value.cast::<PyDict>() {
        return table_of(table, path).map(Value::Table);
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
        return value.extract().map(Value::Integer);
    }
    // An array, or a number of one: as lists and numbers of Python.
    if let Ok(method) = value.getattr("tolist") {
        return value_of(&method.call0()?, path);
    }
    if let Ok(items) = value.try_iter() {
        let items = items.enumerate();
        let items = items.map(|(at, item)| value_of(&item?, &format!("{path}[{at}]")));
        return items.collect::<PyResult<_>>().map(Value::Array);
    }
    let kind = value.get_type();
    let kind = kind.name()?;
    Err(PyTypeError::new_err(format!(
        "{path}: a scene holds numbers, strings, booleans, lists and tables, not {kind}"
    )))
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
