//! The exported function and the list of parts.

use leafwise_plugin_abi::LwPart;

use crate::info::Info;

/// The C layout, for the macro's use.
pub use leafwise_plugin_abi as abi;

/// A pointer to a part's constant entry.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct PartPointer(*const LwPart);

impl PartPointer {
    /// The pointer to `part`.
    pub const fn new(part: &'static LwPart) -> Self {
        Self(part)
    }
}

// SAFETY: points to constant data.
unsafe impl Sync for PartPointer {}

/// A part of `kind` (a constant `LW_KIND_…`) that consists of formulas alone.
pub const fn formulas_part(info: Info, kind: u32) -> LwPart {
    info.part(kind)
}

/// Exports a plugin: its vendor, licence and parts.
///
/// ```text
/// export_plugin! {
///     id: "acme", license: "MIT OR Apache-2.0",
///     parts: [realization Cayley, system Gyrostat, system_formulas PENDULUM]
/// }
/// ```
///
/// The words before the types: `system`, `realization` (chart or general), `one_form`, `embedding`,
/// `flow`, `step_map`. Before a constant [`Info`] of a part of formulas alone the words are:
/// `system_formulas`, `realization_formulas`, `dynamics_formulas`, `step_map_formulas`.
#[macro_export]
macro_rules! export_plugin {
    (id: $id:literal, license: $license:literal,
     parts: [$($kind:ident $part:ident),+ $(,)?] $(,)?) => {
        const _: () = {
            static PARTS: &[$crate::PartPointer] = &[$({
                const PART: &$crate::abi::LwPart = &$crate::export_plugin!(@$kind $part);
                $crate::PartPointer::new(PART)
            }),+];
            static ENTRY: $crate::abi::LwEntry = {
                let mut entry = $crate::abi::LwEntry::empty();
                entry.magic = $crate::abi::LW_MAGIC;
                entry.abi_major = $crate::abi::LW_ABI_MAJOR;
                entry.real_bytes = 8;
                entry.part_count = PARTS.len() as u32;
                entry.parts = PARTS.as_ptr().cast();
                entry.id = concat!($id, "\0").as_ptr().cast();
                entry.version = concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast();
                entry.license = concat!($license, "\0").as_ptr().cast();
                entry.toolchain = c"rust".as_ptr();
                entry
            };
            /// The one exported function.
            #[unsafe(no_mangle)]
            pub extern "C" fn leafwise_plugin_entry_v1() -> *const $crate::abi::LwEntry {
                &ENTRY
            }
        };
    };
    (@system $part:ident) => { $crate::system_part::<$part>() };
    (@realization $part:ident) => { $crate::realization_part::<$part>() };
    (@one_form $part:ident) => { $crate::one_form_part::<$part>() };
    (@embedding $part:ident) => { $crate::embedding_part::<$part>() };
    (@flow $part:ident) => { $crate::flow_part::<$part>() };
    (@step_map $part:ident) => { $crate::step_map_part::<$part>() };
    (@system_formulas $info:ident) => {
        $crate::formulas_part($info, $crate::abi::LW_KIND_SYSTEM)
    };
    (@realization_formulas $info:ident) => {
        $crate::formulas_part($info, $crate::abi::LW_KIND_REALIZATION)
    };
    (@dynamics_formulas $info:ident) => {
        $crate::formulas_part($info, $crate::abi::LW_KIND_DYNAMICS)
    };
    (@step_map_formulas $info:ident) => {
        $crate::formulas_part($info, $crate::abi::LW_KIND_STEP_MAP)
    };
}
