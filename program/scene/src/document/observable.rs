//! Columns that a scene records beside the state.

use super::located::Located;

/// One observable.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservableSpec {
    /// Name of its column, where the scene gives it one.
    pub name: Option<Located<String>>,
    /// `energy`, a Casimir's name, or a formula of the state.
    pub formula: Located<String>,
}

impl ObservableSpec {
    /// The heading of its column.
    pub fn heading(&self) -> &str {
        &self.name.as_ref().unwrap_or(&self.formula).value
    }
}
