//! Arrays in the place of the files of a scene's tables.

use std::sync::Arc;

use leafwise::core::{NumberArray, Registry};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, ToPyArray};
use pyo3::prelude::*;

/// Arrays by the names of tables.
#[derive(Clone, Default)]
pub(crate) struct Arrays(Vec<(String, Arc<NumberArray>)>);

impl Arrays {
    pub(crate) fn of(given: Vec<(String, PyReadonlyArrayDyn<'_, f64>)>) -> Self {
        let arrays = given.into_iter().map(|(name, array)| {
            let array = array.as_array();
            let own = NumberArray {
                shape: array.shape().to_vec(),
                numbers: array.iter().copied().collect(),
            };
            (name, Arc::new(own))
        });
        Self(arrays.collect())
    }

    /// Adds the arrays to what a scene may name.
    pub(crate) fn join(&self, registry: &mut Registry) {
        for (name, array) in &self.0 {
            registry.add_array(name.clone(), NumberArray::clone(array));
        }
    }

    /// Those whose numbers no override replaces: neither `system.tables`, nor the table, nor its `values` or `file`.
    pub(crate) fn without(&self, overrides: &[(String, String)]) -> Self {
        let is_replaced = |name: &str| {
            let table = format!("system.tables.{name}");
            let mut paths = overrides.iter().map(|(path, _)| path.as_str());
            paths.any(|path| {
                let is_above = ["system", "system.tables", &table].contains(&path);
                is_above
                    || ["values", "file"]
                        .iter()
                        .any(|key| path == format!("{table}.{key}"))
            })
        };
        let kept = self.0.iter().filter(|(name, _)| !is_replaced(name));
        Self(kept.cloned().collect())
    }

    /// The names of the tables.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// The same as they came.
    pub(crate) fn given(&self, py: Python<'_>) -> PyResult<Vec<(String, Py<PyArrayDyn<f64>>)>> {
        let arrays = self.0.iter().map(|(name, array)| {
            let flat = array.numbers.to_pyarray(py);
            let shaped = flat.reshape(array.shape.clone())?;
            Ok((name.clone(), shaped.unbind()))
        });
        arrays.collect()
    }
}
