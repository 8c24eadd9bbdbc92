//! The host's own maps, handed to a plugin: the same tables that plugins hand to the host.

use core::ffi::c_void;

use crate::realization::LwRealization;
use crate::system::LwSystem;

/// The host's Poisson system with its parameters fixed, for a part to call. The host owns it; it is
/// valid from `create` until the instance's `destroy` returns.
///
/// *Threads*: call it only during a call of the host on the instance it was given to (`create` and
/// `destroy` included), and on the same thread. A part that is `LW_FLAG_SHAREABLE` may do so from
/// several such calls at once. A status other than `LW_OK` is to be returned to the host.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwHostSystem {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// 0; no flag is defined for systems.
    pub flags: u32,
    /// The first argument of the functions.
    pub instance: *mut c_void,
    /// The functions; `life` is all NULL. The required ones are present; the optional ones are
    /// present where the system is given by formulas, otherwise they may be NULL.
    pub functions: *const LwSystem,
}

/// The host's realization, for a dynamic approximation to call. Ownership and threads as for
/// `LwHostSystem`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwHostRealization {
    /// Bytes of this struct known to the host.
    pub struct_size: u32,
    /// `LW_FLAG_EXACT`, `LW_FLAG_COTANGENT_CHART` and `LW_FLAG_REVERSIBLE`, as for the realization's
    /// part.
    pub flags: u32,
    /// The order n of the realization; 0 with `LW_FLAG_EXACT`.
    pub order: i32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the functions.
    pub instance: *mut c_void,
    /// The functions; `life` is all NULL. `alpha`, `beta`, `sigma`, `space_dimension` are present,
    /// the others may be NULL.
    pub functions: *const LwRealization,
}
