//! A part as chosen.

use leafwise_core::part::{ParameterDefault, ParameterSetting, PartKind};
use leafwise_core::{Origin, PartParameters, Registry};
use serde::{Serialize, Serializer};

use crate::document::{MethodParts, MethodTable, PartUse};
use crate::json::object;

/// A part as chosen, with all its parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartChoice {
    /// Realization or dynamics.
    pub kind: PartKind,
    /// The part's name.
    pub name: &'static str,
    /// Every parameter with its value.
    #[serde(serialize_with = "object")]
    pub parameters: Vec<(&'static str, ParameterSetting)>,
    /// Where it comes from.
    pub origin: Option<Origin>,
    /// Whether the scene left the choice open.
    #[serde(rename = "chosen", serialize_with = "chosen")]
    pub is_automatic: bool,
    /// Why it was taken, where it was chosen by the tensor.
    #[serde(skip)]
    pub reason: Option<String>,
    /// Where its values come from, for a loaded part: `expressions` or `numbers`.
    #[serde(skip)]
    pub path: Option<&'static str>,
}

/// Who chose a part, in words.
fn chosen<S: Serializer>(is_automatic: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *is_automatic {
        "automatically"
    } else {
        "by the scene"
    })
}

impl PartChoice {
    /// The tolerance of a stepper that chooses substeps of its own by it.
    pub fn tolerance(&self) -> Option<f64> {
        let mut parameters = self.parameters.iter();
        parameters.find_map(|(name, value)| match value {
            ParameterSetting::Real(tolerance)
                if self.kind == PartKind::Stepper && *name == "tolerance" =>
            {
                Some(*tolerance)
            }
            _ => None,
        })
    }

    /// The length of the only steps that a dynamic approximation holds for.
    pub fn time_step(&self) -> Option<f64> {
        let mut parameters = self.parameters.iter();
        parameters.find_map(|(name, value)| match value {
            ParameterSetting::Real(length)
                if self.kind == PartKind::Dynamics && *name == "time-step" && *length > 0.0 =>
            {
                Some(*length)
            }
            _ => None,
        })
    }

    /// Its parameters, to build it again.
    pub(super) fn given(&self) -> PartParameters {
        let parameters = self.parameters.iter();
        parameters.fold(PartParameters::new(), |given, (name, value)| {
            given.with(*name, value.clone())
        })
    }

    /// The name with the values that tell it from its relatives: numbers, and words that are not the
    /// part's usual ones. Formulas are too long for that.
    pub fn line(&self, registry: &Registry) -> String {
        let parts = registry.parts();
        let info = parts
            .iter()
            .find(|p| p.kind == self.kind && p.name == self.name);
        let is_usual = |name: &str, value: &ParameterSetting| {
            let known = info.and_then(|info| info.parameters.iter().find(|p| p.name == name));
            matches!(value, ParameterSetting::Text(_))
                && known.is_some_and(|p| {
                    let is_formulas = matches!(p.default, ParameterDefault::Formulas(_));
                    is_formulas || ParameterSetting::from(p.default) == *value
                })
        };
        // 0 in place of a number that the part finds itself says nothing.
        let is_open = |value: &ParameterSetting| matches!(value, ParameterSetting::Integer(0));
        let told = self
            .parameters
            .iter()
            .filter(|(name, value)| !is_usual(name, value) && !is_open(value));
        told.fold(self.name.to_owned(), |text, (name, value)| {
            text + &format!(" {name} {value}")
        })
    }
}

impl MethodTable {
    /// The method of parts as chosen, `auto` replaced by what was taken.
    pub fn of_choices(choices: &[PartChoice]) -> Option<Self> {
        let of = |kind: PartKind| {
            let choice = choices.iter().find(|choice| choice.kind == kind)?;
            let parameters = choice.parameters.iter();
            Some(PartUse {
                name: choice.name.to_owned(),
                parameters: parameters
                    .map(|(name, value)| ((*name).to_owned(), value.clone()))
                    .filter(|(_, value)| *value != ParameterSetting::Text(String::new()))
                    .collect(),
            })
        };
        let parts = match of(PartKind::Stepper) {
            Some(stepper) => MethodParts::Stepper(stepper),
            None => MethodParts::Pair {
                realization: of(PartKind::Realization)?,
                dynamics: of(PartKind::Dynamics)?,
            },
        };
        Some(Self {
            parts,
            composition: of(PartKind::Composition),
        })
    }
}
