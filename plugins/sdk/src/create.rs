//! Arguments from which a part makes an instance: dimension, parameters, partners.

use std::ffi::CStr;

use leafwise_plugin_abi::{
    LW_SETTING_INTEGER, LW_SETTING_REAL, LW_SETTING_TEXT, LwCreate, LwSetting,
};

use crate::fail::Fail;
use crate::host::{HostRealization, HostSystem};

/// Arguments of [`Part::create`](crate::Part::create), given by the host: dimension, parameters,
/// partners.
#[derive(Clone, Copy)]
pub struct Create<'a> {
    raw: &'a LwCreate,
}

impl<'a> Create<'a> {
    pub(crate) fn new(raw: &'a LwCreate) -> Self {
        Self { raw }
    }

    /// d, the dimension of M; 0 for a system, which says it itself.
    pub fn dimension(&self) -> usize {
        self.raw.dim
    }

    /// The value of a whole-number parameter.
    ///
    /// # Errors
    /// [`Fail::Unsupported`] when the part declares no such parameter of this type.
    pub fn integer(&self, name: &str) -> Result<i64, Fail> {
        let setting = self.setting(name)?;
        match setting.kind {
            LW_SETTING_INTEGER => Ok(setting.integer),
            _ => Err(other_type(name, "a whole number")),
        }
    }

    /// The value of a numeric parameter.
    ///
    /// # Errors
    /// As [`integer`](Self::integer).
    pub fn real(&self, name: &str) -> Result<f64, Fail> {
        let setting = self.setting(name)?;
        match setting.kind {
            LW_SETTING_INTEGER | LW_SETTING_REAL => Ok(setting.real),
            _ => Err(other_type(name, "a number")),
        }
    }

    /// The value of a word parameter.
    ///
    /// # Errors
    /// As [`integer`](Self::integer).
    pub fn text(&self, name: &str) -> Result<&'a str, Fail> {
        let setting = self.setting(name)?;
        if setting.kind != LW_SETTING_TEXT || setting.text.is_null() {
            return Err(other_type(name, "a word"));
        }
        // SAFETY: the host's string, valid during `create`.
        let text = unsafe { CStr::from_ptr(setting.text) };
        text.to_str().map_err(|_| other_type(name, "UTF-8"))
    }

    /// The system to serve.
    ///
    /// # Errors
    /// [`Fail::Unsupported`] for a part of a kind that gets none.
    pub fn system(&self) -> Result<HostSystem, Fail> {
        HostSystem::new(self.raw.system, self.raw.dim)
    }

    /// The realization to serve.
    ///
    /// # Errors
    /// [`Fail::Unsupported`] for a part that is not a dynamic approximation.
    pub fn realization(&self) -> Result<HostRealization, Fail> {
        HostRealization::new(self.raw.realization)
    }

    fn setting(&self, name: &str) -> Result<&'a LwSetting, Fail> {
        let settings: &[LwSetting] = if self.raw.settings.is_null() {
            &[]
        } else {
            // SAFETY: the host's array of `setting_count` settings, valid during `create`.
            unsafe { std::slice::from_raw_parts(self.raw.settings, self.raw.setting_count) }
        };
        let named = |setting: &&LwSetting| {
            // SAFETY: NULL, or the host's string, valid during `create`.
            !setting.name.is_null()
                && unsafe { CStr::from_ptr(setting.name) }.to_bytes() == name.as_bytes()
        };
        settings
            .iter()
            .find(named)
            .ok_or_else(|| Fail::unsupported(format!("the part declares no parameter `{name}`")))
    }
}

fn other_type(name: &str, wanted: &str) -> Fail {
    Fail::unsupported(format!("parameter `{name}` is not {wanted}"))
}
