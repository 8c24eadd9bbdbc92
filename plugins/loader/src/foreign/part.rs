//! A part of a library with functions.

use leafwise_core::part::{PATH, ParameterSetting, PartInfo};
use leafwise_core::{BuildError, PartParameters};
use leafwise_plugin_abi::{LwLifecycle, LwProperties};

use super::failure::{CallFailure, MESSAGE, error_into, failure};
use super::making::{HostObjects, Making, with_arguments};
use crate::declaration::{Dimensions, Flags, Functions, PartDeclaration, broken_promise};
use crate::exits::in_call;

/// A part with functions: its declaration and its table, shared by all its wrappers.
#[derive(Debug)]
pub(crate) struct ForeignPart {
    /// Its declaration.
    pub info: &'static PartInfo,
    /// The dimensions it serves.
    pub dimensions: Dimensions,
    order: i32,
    structure: i32,
    flags: Flags,
    /// Its functions.
    pub functions: Functions,
}

/// Order, structure and flags that a part promises for given parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Properties {
    /// n, m or the order in t, at least 1.
    pub order: usize,
    /// `LW_STRUCTURE_…`.
    pub structure: i32,
    /// Exact, symplectic, self-adjoint.
    pub flags: Flags,
}

impl ForeignPart {
    /// The part of a declaration with functions.
    pub(crate) fn new(
        declaration: &PartDeclaration,
        functions: Functions,
        info: &'static PartInfo,
    ) -> Self {
        Self {
            info,
            dimensions: declaration.dimensions,
            order: declaration.order,
            structure: declaration.structure,
            flags: declaration.flags,
            functions,
        }
    }

    /// Its name.
    pub(crate) fn name(&self) -> &'static str {
        self.info.name
    }

    /// Whether points of S are pairs (x, p).
    pub(crate) fn has_cotangent_chart(&self) -> bool {
        self.flags.has_cotangent_chart()
    }

    /// Whether β̂(x, p) = α̂(x, −p).
    pub(crate) fn is_reversible(&self) -> bool {
        self.flags.is_reversible()
    }

    pub(super) fn lifecycle(&self) -> &LwLifecycle {
        self.functions.lifecycle()
    }

    /// A value for each of the part's own parameters, defaults filled in.
    pub(crate) fn settings(
        &self,
        parameters: &PartParameters,
    ) -> Result<Vec<(String, ParameterSetting)>, BuildError> {
        own_settings(self.info, parameters)
    }

    /// Refuses a dimension that the part does not serve.
    pub(crate) fn check_dimension(&self, d: usize) -> Result<(), BuildError> {
        self.dimensions.check(self.name(), d)
    }

    /// Its promises for these parameters, by the library's `properties` where it has that function.
    ///
    /// # Errors
    /// The failure of that call, or promises that contradict each other.
    pub(crate) fn properties(
        &self,
        dimension: usize,
        settings: &[(String, ParameterSetting)],
    ) -> Result<Properties, CallFailure> {
        let mut raw = LwProperties {
            order: self.order,
            structure: self.structure,
            flags: self.flags.0,
            ..LwProperties::empty()
        };
        let making = Making {
            dimension,
            settings,
        };
        if let Some(properties) = self.lifecycle().properties {
            let mut message = [0; MESSAGE];
            let mut error = error_into(&mut message);
            let status = with_arguments(making, &HostObjects::default(), |arguments| {
                in_call(&self.info.name, || {
                    // SAFETY: the arguments, the properties and the error live during the call.
                    unsafe { properties(arguments, &mut raw, &mut error) }
                })
            });
            failure(status, &error, &message)?;
        }
        let flags = Flags(raw.flags);
        if let Some(problem) = broken_promise(self.info.kind, raw.order, raw.structure, flags) {
            return Err(CallFailure::Failed {
                point: None,
                message: format!("properties: {problem}"),
            });
        }
        Ok(Properties {
            order: usize::try_from(raw.order).unwrap_or(0).max(1),
            structure: raw.structure,
            flags,
        })
    }
}

/// A value for each parameter that the part itself declares.
pub(crate) fn own_settings(
    info: &PartInfo,
    parameters: &PartParameters,
) -> Result<Vec<(String, ParameterSetting)>, BuildError> {
    parameters.refuse_unknown(info)?;
    let own = info.parameters.iter().filter(|p| p.name != PATH);
    own.map(|parameter| {
        let default: ParameterSetting = parameter.default.into();
        let given = match &default {
            ParameterSetting::Integer(_) => parameters.get(info, parameter.name)?.into(),
            ParameterSetting::Real(_) => parameters.real(info, parameter.name)?.into(),
            ParameterSetting::Text(_) => match parameters.setting(info, parameter.name)? {
                word @ ParameterSetting::Text(_) => word,
                other => {
                    return Err(BuildError::Parameter {
                        part: info.name,
                        parameter: parameter.name.to_owned(),
                        value: other.to_string(),
                        expected: format!("`{}` is a word", parameter.name),
                    });
                }
            },
        };
        Ok((parameter.name.to_owned(), given))
    })
    .collect()
}
