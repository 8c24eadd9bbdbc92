//! From the pointer that the entry function returns to a checked [`PluginDeclaration`].
//!
//! - `memory`: copies of structs, lists and strings, as large as their writer says;
//! - `part`: one part;
//! - `parameters`: its parameters.

pub(crate) mod memory;
mod parameters;
mod part;

use leafwise_plugin_abi::{LW_ABI_MAJOR, LW_ABI_MINOR, LW_FROZEN_BYTES, LW_MAGIC, LwEntry};

use crate::declaration::PluginDeclaration;
use crate::error::Refusal;
use memory::{copy, list, required_text, text};

/// Copies and checks everything the entry leads to.
///
/// # Safety
/// `entry` is what the entry function of a library that is never unloaded returned.
pub(crate) unsafe fn read(entry: *const LwEntry) -> Result<PluginDeclaration, Refusal> {
    if entry.is_null() {
        return Err(Refusal::NullEntry);
    }
    // SAFETY: the first bytes are the same in every version of the interface.
    unsafe { check_frozen(entry) }?;
    // SAFETY: it is an entry of this version.
    let entry = unsafe { copy(entry) }?;
    // SAFETY: strings and lists of an entry of this version, here and below.
    let id = unsafe { required_text(|| "the plugin's id".to_owned(), entry.id) }?;
    check_vendor(&id)?;
    // SAFETY: as above.
    let version = unsafe { required_text(|| "the plugin's version".to_owned(), entry.version) }?;
    let optional = |what: &'static str, pointer| {
        // SAFETY: as above.
        unsafe {
            text(
                || format!("the plugin's {what}"),
                pointer,
                memory::LONGEST_TEXT,
            )
        }
    };
    let count = entry.part_count as usize;
    // SAFETY: as above.
    let pointers = unsafe { list(|| "the list of parts".to_owned(), entry.parts, count) }?;
    let mut parts = Vec::with_capacity(count);
    for (place, pointer) in pointers.into_iter().enumerate() {
        // SAFETY: as above.
        parts.push(unsafe { part::read(place, pointer, &id) }?);
    }
    for (place, part) in parts.iter().enumerate() {
        if parts[..place].iter().any(|other| other.id() == part.id()) {
            return Err(Refusal::TwoOfOneId {
                id: part.id().to_owned(),
            });
        }
    }
    Ok(PluginDeclaration {
        id,
        version,
        license: optional("license", entry.license)?,
        toolchain: optional("toolchain", entry.toolchain)?,
        abi: format!("{}.{}", entry.abi_major, entry.abi_minor),
        parts,
    })
}

/// Checks the bytes that no version changes.
///
/// # Safety
/// `entry` leads to at least as many bytes.
unsafe fn check_frozen(entry: *const LwEntry) -> Result<(), Refusal> {
    const { assert!(LW_FROZEN_BYTES == 24) };
    if !entry.addr().is_multiple_of(align_of::<LwEntry>()) {
        return Err(Refusal::Misaligned {
            what: "LwEntry".to_owned(),
        });
    }
    // SAFETY: aligned, and the fields are in the bytes that are there.
    let (magic, major, minor, real_bytes) = unsafe {
        (
            (*entry).magic,
            (*entry).abi_major,
            (*entry).abi_minor,
            (*entry).real_bytes,
        )
    };
    if magic != LW_MAGIC {
        return Err(Refusal::BadMagic { found: magic });
    }
    if major != LW_ABI_MAJOR || minor > LW_ABI_MINOR {
        return Err(Refusal::Abi { major, minor });
    }
    if real_bytes as usize != size_of::<f64>() {
        return Err(Refusal::RealBytes { found: real_bytes });
    }
    Ok(())
}

/// Lower-case letters, digits and `-`.
fn is_word(word: &str) -> bool {
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !word.is_empty() && word.chars().all(fits)
}

fn check_vendor(id: &str) -> Result<(), Refusal> {
    if is_word(id) {
        return Ok(());
    }
    Err(Refusal::Text {
        what: format!("the plugin's id `{id}`"),
        problem: "is not a word of lower-case letters, digits and `-`".to_owned(),
    })
}

#[cfg(test)]
mod tests;
