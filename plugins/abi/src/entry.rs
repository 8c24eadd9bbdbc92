//! The one exported function and what it returns.

use core::ffi::{CStr, c_char};

use crate::part::LwPart;

/// The ABI's major version, also in the entry function's name: other majors do not load.
pub const LW_ABI_MAJOR: u16 = 1;
/// The ABI's minor version described here.
pub const LW_ABI_MINOR: u16 = 0;
/// The first bytes of `LwEntry`.
pub const LW_MAGIC: [u8; 8] = *b"LEAFWISE";
/// The size of the part of `LwEntry` that no version changes.
pub const LW_FROZEN_BYTES: usize = 24;
/// The name of the entry function.
pub const LW_ENTRY_SYMBOL: &CStr = c"leafwise_plugin_entry_v1";
/// The name of any major version's entry function, without the major version.
pub const LW_ENTRY_SYMBOL_STEM: &str = "leafwise_plugin_entry_v";

/// The plugin's list of parts, returned by the entry function: constant data that lives until the
/// process ends. Its first 24 bytes, up to `part_count`, are the same in every version.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LwEntry {
    /// `LW_MAGIC`, the letters LEAFWISE.
    pub magic: [u8; 8],
    /// `LW_ABI_MAJOR`.
    pub abi_major: u16,
    /// The lowest minor version of the ABI that the plugin needs of its host: 0 where it uses nothing
    /// newer, whatever header it was built with.
    pub abi_minor: u16,
    /// Bytes of this struct known to its author.
    pub struct_size: u32,
    /// The size of the plugin's real numbers: 8.
    pub real_bytes: u32,
    /// The number of parts.
    pub part_count: u32,
    /// The parts: an array of pointers, so that a part may grow.
    pub parts: *const *const LwPart,
    /// The plugin's own name, the `vendor` of its parts' ids. Required.
    pub id: *const c_char,
    /// Its version, such as `0.3.1`. Required.
    pub version: *const c_char,
    /// Its licence, as an SPDX expression. Optional.
    pub license: *const c_char,
    /// The compiler or toolchain that built it, for reports. Optional.
    pub toolchain: *const c_char,
}

/// The type of the entry function. It returns constant data, never NULL, and does nothing else.
/// *Threads*: called once, on the thread that loads the plugin.
pub type LwEntryFn = Option<unsafe extern "C" fn() -> *const LwEntry>;
