//! Arguments of a part's `create` and `properties`: dimension, settings, lent objects.

use std::ffi::CString;

use leafwise_core::part::ParameterSetting;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_plugin_abi::{
    LW_SETTING_INTEGER, LW_SETTING_REAL, LW_SETTING_TEXT, LwCreate, LwSetting,
};
use leafwise_scene::json::object;
use serde::Serialize;

use crate::host::{HostRealization, HostSystem};

/// Dimension and settings that an instance is made from; serialized, the settings as JSON.
#[derive(Clone, Copy, Serialize)]
#[serde(transparent)]
pub(crate) struct Making<'a> {
    /// d; 0 for a system.
    #[serde(skip)]
    pub dimension: usize,
    /// A value for each of the part's own parameters, in their order.
    #[serde(serialize_with = "object")]
    pub settings: &'a [(String, ParameterSetting)],
}

/// Objects that the host lends an instance: dropped after it.
#[derive(Default)]
pub(crate) struct HostObjects {
    /// The system to serve.
    pub system: Option<HostSystem>,
    /// The realization to serve.
    pub realization: Option<HostRealization>,
}

impl HostObjects {
    /// A system with these values of its parameters.
    ///
    /// # Errors
    /// Those of [`HostSystem::new`].
    pub(crate) fn of_system(
        system: &PoissonSystem,
        parameters: &[f64],
    ) -> Result<Self, BuildError> {
        Ok(Self {
            system: Some(HostSystem::new(system, parameters)?),
            realization: None,
        })
    }
}

/// Calls `call` with the arguments of `create` and `properties`.
pub(super) fn with_arguments<T>(
    making: Making<'_>,
    lent: &HostObjects,
    call: impl FnOnce(&LwCreate) -> T,
) -> T {
    // Names with numbers and words can all be written.
    let params = text(&serde_json::to_string(&making).unwrap_or_default());
    let texts: Vec<(CString, CString)> = making
        .settings
        .iter()
        .map(|(name, setting)| (text(name), text(&setting.to_string())))
        .collect();
    let settings: Vec<LwSetting> = making
        .settings
        .iter()
        .zip(&texts)
        .map(|((_, setting), (name, word))| raw_setting(setting, name, word))
        .collect();
    let system = lent.system.as_ref().map(HostSystem::raw);
    let realization = lent.realization.as_ref().map(HostRealization::raw);
    call(&LwCreate {
        dim: making.dimension,
        params: params.as_ptr(),
        settings: settings.as_ptr(),
        setting_count: settings.len(),
        system: system.unwrap_or(std::ptr::null()),
        realization: realization.unwrap_or(std::ptr::null()),
        ..LwCreate::empty()
    })
}

fn raw_setting(setting: &ParameterSetting, name: &CString, word: &CString) -> LwSetting {
    let mut raw = LwSetting {
        name: name.as_ptr(),
        kind: LW_SETTING_TEXT,
        reserved: 0,
        integer: 0,
        real: 0.0,
        text: std::ptr::null(),
    };
    match setting {
        ParameterSetting::Integer(value) => {
            raw.kind = LW_SETTING_INTEGER;
            raw.integer = *value;
            raw.real = *value as f64;
        }
        ParameterSetting::Real(value) => {
            raw.kind = LW_SETTING_REAL;
            raw.real = *value;
        }
        ParameterSetting::Text(_) => raw.text = word.as_ptr(),
    }
    raw
}

/// A text as C has it; what stands behind a NUL is left out.
fn text(text: &str) -> CString {
    let until_nul = text.split('\0').next().unwrap_or_default();
    CString::new(until_nul).unwrap_or_default()
}
