//! Tables of Python as text of a scene.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
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
