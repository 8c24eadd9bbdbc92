//! How a call ended, and the text that says why.

use core::ffi::c_char;

/// How a call ended: one of `LW_OK`, `LW_DISCARD`, `LW_ERROR`, `LW_FATAL`, `LW_UNSUPPORTED`; any
/// other value means `LW_ERROR`.
pub type LwStatus = i32;

/// Done; the whole output is written.
pub const LW_OK: i32 = 0;

/// The point is outside the part's domain (the neighbourhood U_ε of a local realization), or an
/// inner iteration did not converge there. The instance is unchanged; the host may try a smaller
/// epsilon or h.
pub const LW_DISCARD: i32 = 1;

/// The call failed for another reason, told in `LwError`. The instance is unchanged and may be
/// called again.
pub const LW_ERROR: i32 = -1;

/// The instance is broken (a caught panic, a violated invariant): the host never calls it again,
/// not even to destroy it.
pub const LW_FATAL: i32 = -2;

/// The part does not serve this dimension, tensor, parameter or partner (from `create` or
/// `properties`), or this instance does not offer the function that was called. A property of the
/// instance: asking again gives the same answer.
pub const LW_UNSUPPORTED: i32 = -3;

/// Place where a failing call says why. The caller owns it and its text buffer, and sets
/// `struct_size`, `capacity`, `message` to an empty text, `point` = -1 and `ratio` = 0. The callee
/// writes to it only when it returns a status other than `LW_OK`, and keeps no pointer to it.
///
/// Never NULL in calls of the host to a plugin; a plugin that calls the host may pass NULL.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwError {
    /// Bytes of this struct known to the caller.
    pub struct_size: u32,
    /// Bytes at `message`, the terminating NUL included; 0 when no text is wanted.
    pub capacity: u32,
    /// Room for one line of UTF-8 with a NUL at the end: what failed, at which values, what to try.
    /// Longer texts are cut.
    pub message: *mut c_char,
    /// Index of the first point of the batch that failed, or -1 when that is not known.
    ///
    /// When it is at least 0, the output of all points before it is complete, and the host may
    /// resume behind it. When it is -1, no output counts, and the host may call point by point.
    pub point: i64,
    /// With `LW_DISCARD`: how far the point is from the section σ over how far the domain reaches
    /// there (greater than 1: outside); 0 when that is not known.
    pub ratio: f64,
}
