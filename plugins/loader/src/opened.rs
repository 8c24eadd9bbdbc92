//! A library opened, read and tried, before anything of it is registered.

use std::path::Path;

use leafwise_core::Part;

use crate::declaration::PluginDeclaration;
use crate::error::Refusal;
use crate::file::CheckedFile;
use crate::formulas;
use crate::library;
use crate::part::part;
use crate::smoke::{Tried, try_part};

/// A library that passed every check, not yet registered.
pub(crate) struct Opened {
    pub declaration: PluginDeclaration,
    pub parts: Vec<Part>,
    pub tried: Vec<Tried>,
}

/// Opens a library, which is to be the file that was checked, reads what it declares and tries every
/// part.
pub(crate) fn open_and_try(path: &Path, checked: &CheckedFile) -> Result<Opened, Refusal> {
    let declaration = library::open(path, checked)?;
    let mut parts = Vec::with_capacity(declaration.parts.len());
    let mut tried = Vec::with_capacity(declaration.parts.len());
    for declared in &declaration.parts {
        formulas::check(declared)?;
        let info = declared.info();
        tried.push(try_part(declared, info).map_err(|failure| Refusal::Smoke {
            part: declared.id().to_owned(),
            failure,
        })?);
        parts.push(part(declared, info)?);
    }
    Ok(Opened {
        declaration,
        parts,
        tried,
    })
}
