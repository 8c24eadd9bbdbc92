//! The C layout that Leafwise and its plugins share, ABI 1.0: types and constants, no code.
//!
//! A plugin is a shared library with one exported function, `leafwise_plugin_entry_v1`, which
//! returns an [`LwEntry`]: a list of [`LwPart`]s. A part is a system ([`LwSystem`]), a realization
//! ([`LwRealization`]), a dynamic approximation ([`LwDynamics`]) or a step map ([`LwStepMap`]). Its
//! values come as numbers (a table of batched functions), as expressions ([`LwExpression`]) or as
//! both. The same layout in C is `include/leafwise_plugin.h`, generated from this crate.
//!
//! # Rules
//!
//! - **Growth.** A minor version only appends fields. A struct that starts with `struct_size` says
//!   how many of its bytes its writer knows. The reader copies the smaller of that and its own size
//!   into zeroed memory: a field the writer does not know is NULL or 0. Structs without
//!   `struct_size`, and [`LwLifecycle`], which stands inside others, are frozen for ABI 1. The
//!   field [`LwEntry::abi_minor`] is the lowest minor version the plugin needs of its host.
//! - **NULL.** Function fields may be NULL. The host refuses a part without one that is "required".
//!   Reserved fields are 0. Unknown flag bits are ignored, an unknown status is [`LW_ERROR`].
//! - **Strings** are UTF-8 with a NUL at the end. Those reachable from [`LwEntry`] live until the
//!   process ends.
//! - **Memory.** Nothing is allocated on one side and freed on the other. The caller owns every
//!   buffer of a call. The callee keeps no pointer into it. Inputs and output do not overlap.
//! - **Purity.** A map's result depends on the instance and on the point alone. It does not depend
//!   on earlier calls, nor on which other points share the batch. The same point gives the same
//!   bits.
//! - **Threads.** No two calls on one instance overlap in time, unless the part is declared
//!   [`LW_FLAG_SHAREABLE`]. Consecutive calls may come from different threads. Different instances
//!   are made, called and destroyed in parallel. What a call needs therefore lies in its instance
//!   or on the stack, not in static memory (C's `static`, Fortran's SAVE and COMMON). A plugin
//!   starts no threads of its own by default.
//! - **Process.** A plugin leaves floating-point control registers, locale, signal handlers and
//!   panic hook as they were. It does not call `exit`, and lets no exception or panic out. It is
//!   never unloaded.
//! - **Units.** Numbers are doubles in the units of the scene. The signs are Π_ij = {x_i, x_j} and
//!   ẋ = {H, x} = −Π ∇H, whatever convention a part's expressions use.
#![no_std]

#[cfg(not(target_pointer_width = "64"))]
compile_error!("plugin ABI 1 is laid out for 64-bit targets only");

mod call;
mod dynamics;
mod entry;
mod expression;
mod instance;
mod layout;
mod part;
mod status;
mod step_map;
mod tables;

pub use call::{LwInput, LwMapCall, LwMapFn, LwOutput};
pub use dynamics::LwDynamics;
pub use entry::{
    LW_ABI_MAJOR, LW_ABI_MINOR, LW_ENTRY_SYMBOL, LW_ENTRY_SYMBOL_STEM, LW_FROZEN_BYTES, LW_MAGIC,
    LwEntry, LwEntryFn,
};
pub use expression::LwExpression;
pub use instance::{
    LW_SETTING_INTEGER, LW_SETTING_REAL, LW_SETTING_TEXT, LwCreate, LwHostRealization,
    LwHostSystem, LwLifecycle, LwProperties, LwRealization, LwSetting, LwSystem,
};
pub use layout::{LAYOUT, TypeLayout};
pub use part::{
    LW_FLAG_COTANGENT_CHART, LW_FLAG_EXACT, LW_FLAG_NOT_SELF_ADJOINT, LW_FLAG_REVERSIBLE,
    LW_FLAG_SELF_ADJOINT, LW_FLAG_SHAREABLE, LW_FLAG_SYMPLECTIC, LW_FLAG_UNCORRECTED,
    LW_KIND_DYNAMICS, LW_KIND_REALIZATION, LW_KIND_STEP_MAP, LW_KIND_SYSTEM, LW_STRUCTURE_EXACT,
    LW_STRUCTURE_NONE, LwParameter, LwPart,
};
pub use status::{LW_DISCARD, LW_ERROR, LW_FATAL, LW_OK, LW_UNSUPPORTED, LwError, LwStatus};
pub use step_map::LwStepMap;
