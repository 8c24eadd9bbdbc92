//! Declarations of parts, in text that is made at run time.

use crate::part::{ParameterDefault, ParameterInfo, ParameterSetting, PartInfo, PartKind};

/// [`PartInfo`] with owned text, for parts that are read from a loaded library.
#[derive(Clone, Debug, PartialEq)]
pub struct PartDescription {
    /// Its name in a scene.
    pub name: String,
    /// Its kind.
    pub kind: PartKind,
    /// One line.
    pub summary: String,
    /// Order, exactness, symmetry: what it promises, in words.
    pub declares: String,
    /// Where it is defined: states, tensors, step sizes.
    pub domain: String,
    /// Where it is published.
    pub literature: String,
    /// Its parameters.
    pub parameters: Vec<ParameterDescription>,
}

/// [`ParameterInfo`] with owned text.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterDescription {
    /// Its name in a scene.
    pub name: String,
    /// Meaning of the parameter and values that are allowed, in words.
    pub summary: String,
    /// The value taken when the scene names none; its type is the parameter's.
    pub default: ParameterSetting,
}

impl PartDescription {
    /// The same for as long as the program runs, with the [`PartInfo::paths`] of its values: loaded
    /// libraries are never unloaded, and neither is what they say of themselves. Call it once a part.
    pub fn leak(self, paths: &'static [&'static str]) -> &'static PartInfo {
        let parameters: Vec<ParameterInfo> = self
            .parameters
            .into_iter()
            .map(|parameter| ParameterInfo {
                name: parameter.name.leak(),
                summary: parameter.summary.leak(),
                default: match parameter.default {
                    ParameterSetting::Integer(value) => ParameterDefault::Integer(value),
                    ParameterSetting::Real(value) => ParameterDefault::Real(value),
                    ParameterSetting::Text(value) => ParameterDefault::Text(value.leak()),
                },
            })
            .collect();
        Box::leak(Box::new(PartInfo {
            name: self.name.leak(),
            summary: self.summary.leak(),
            declares: self.declares.leak(),
            domain: self.domain.leak(),
            literature: self.literature.leak(),
            parameters: parameters.leak(),
            paths,
            ..PartInfo::of(self.kind)
        }))
    }
}
