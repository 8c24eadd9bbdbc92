//! Instances: what they are made of, how they are made and ended.

use core::ffi::{c_char, c_void};

use crate::host::{LwHostRealization, LwHostSystem};
use crate::status::{LwError, LwStatus};

/// `LwSetting.kind`: a whole number.
pub const LW_SETTING_INTEGER: u32 = 1;
/// `LwSetting.kind`: a number.
pub const LW_SETTING_REAL: u32 = 2;
/// `LwSetting.kind`: a word.
pub const LW_SETTING_TEXT: u32 = 3;

/// The value of one parameter of a part, of the type of its declared default. Frozen for ABI 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwSetting {
    /// The parameter's name.
    pub name: *const c_char,
    /// `LW_SETTING_INTEGER`, `LW_SETTING_REAL` or `LW_SETTING_TEXT`.
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// The whole number; 0 for other kinds.
    pub integer: i64,
    /// The number, whole numbers included; 0 for a word.
    pub real: f64,
    /// The word; NULL for numbers.
    pub text: *const c_char,
}

/// What an instance is made of. The host owns it; it and its strings are valid during the call only,
/// but `system` and `realization` point to what stays valid until the instance's `destroy` returns.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwCreate {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// d, the dimension of M; 0 for a system, which says it itself, and in `properties` where no
    /// system is chosen yet.
    pub dim: usize,
    /// All parameters as one JSON object: `{"order": 4, "tolerance": 1e-12}`. The same values as
    /// `settings`, for authors who have a JSON reader at hand.
    pub params: *const c_char,
    /// One setting for each entry of `LwPart.parameters`, in the same order, defaults filled in.
    pub settings: *const LwSetting,
    /// The number of settings.
    pub setting_count: usize,
    /// The system to serve, its parameters fixed; NULL for a system, and in `properties` where none
    /// is chosen yet.
    pub system: *const LwHostSystem,
    /// The realization to serve; NULL except for a dynamic approximation.
    pub realization: *const LwHostRealization,
}

/// What a part promises for given parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwProperties {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// As `LwPart.order`.
    pub order: i32,
    /// As `LwPart.structure`.
    pub structure: i32,
    /// As `LwPart.flags`.
    pub flags: u32,
}

/// How instances of a part are made and ended; part of every table of functions. Frozen for ABI 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwLifecycle {
    /// Makes an instance and leaves it at `*instance`; on failure the host ignores `*instance`.
    /// Required. A part without state may leave NULL there.
    ///
    /// The host makes one instance for each thread that needs one and for each set of parameter
    /// values. `LW_UNSUPPORTED`: the part does not serve this system, dimension or parameter.
    /// *Threads*: any, also while other instances are made or called.
    pub create: Option<
        unsafe extern "C" fn(
            args: *const LwCreate,
            instance: *mut *mut c_void,
            err: *mut LwError,
        ) -> LwStatus,
    >,
    /// Ends an instance: frees all that `create` and the calls made. Required. Called once, never
    /// after `LW_FATAL`. *Threads*: any, after the last call on the instance has returned.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Changes those of `properties` that depend on the parameters: the host has filled in what
    /// `LwPart` declares. Optional; NULL when nothing depends on them. Called before any instance
    /// exists. *Threads*: any, also while instances are made or called.
    pub properties: Option<
        unsafe extern "C" fn(
            args: *const LwCreate,
            properties: *mut LwProperties,
            err: *mut LwError,
        ) -> LwStatus,
    >,
}
