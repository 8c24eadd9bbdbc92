//! Parts by name: what they are, what parameters they take, where they come from.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::error::BuildError;

/// The kinds of part a method is assembled from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartKind {
    /// A Poisson system of the library.
    System,
    /// Realization data R̂_ε: a geometric approximation.
    Realization,
    /// A provider of Lagrangian bisections.
    Dynamics,
    /// A map M → M that needs no bisection.
    Stepper,
    /// A composition of step maps.
    Composition,
}

impl PartKind {
    /// The singular noun used in messages.
    pub fn noun(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::Realization => "realization",
            Self::Dynamics => "dynamic approximation",
            Self::Stepper => "stepper",
            Self::Composition => "composition",
        }
    }
}

/// One parameter of a part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterInfo {
    /// Its name in a scene.
    pub name: &'static str,
    /// What it means and what is allowed.
    pub summary: &'static str,
    /// The value taken when the scene names none.
    pub default: i64,
}

/// What a part declares about itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PartInfo {
    /// Its name in a scene.
    pub name: &'static str,
    /// Its kind.
    pub kind: PartKind,
    /// One line.
    pub summary: &'static str,
    /// Order, exactness, symmetry: what it promises, in words.
    pub declares: &'static str,
    /// Where it is defined: states, tensors, step sizes.
    pub domain: &'static str,
    /// Where it is published.
    pub literature: &'static str,
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
}

/// The parameters a scene gives to a part.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartParameters {
    values: BTreeMap<String, i64>,
}

impl PartParameters {
    /// No parameter: every default.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same with one more.
    pub fn with(mut self, name: impl Into<String>, value: i64) -> Self {
        self.values.insert(name.into(), value);
        self
    }

    /// The value of a parameter of `info`, its default where none is given.
    ///
    /// # Errors
    /// [`BuildError::UnknownParameter`] when a given name is not one of `info`'s, or the one asked
    /// for is not.
    pub fn get(&self, info: &PartInfo, name: &str) -> Result<i64, BuildError> {
        let known = |parameter: &str| info.parameters.iter().find(|p| p.name == parameter);
        let unknown = |parameter: &str| BuildError::UnknownParameter {
            part: info.name,
            parameter: parameter.to_owned(),
            known: info
                .parameters
                .iter()
                .map(|p| p.name)
                .collect::<Vec<_>>()
                .join(", "),
        };
        if let Some(stranger) = self.values.keys().find(|key| known(key).is_none()) {
            return Err(unknown(stranger));
        }
        let parameter = known(name).ok_or_else(|| unknown(name))?;
        Ok(self.values.get(name).copied().unwrap_or(parameter.default))
    }
}
