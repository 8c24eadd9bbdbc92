//! Pages with the digest of themselves in their last line: a cut or changed one is known.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::error::RunError;
use super::replaced::replace;

/// Writes a page and its digest.
pub(crate) fn write_page(path: &Path, page: &str) -> Result<(), RunError> {
    replace(path, sealed(page).as_bytes())
}

/// Makes sure that a page is there as it was written; one that is not there is made.
///
/// # Errors
/// [`RunError::Changed`] where it is not what was written.
pub(crate) fn confirm_page(
    path: &Path,
    page: impl FnOnce() -> Result<String, RunError>,
) -> Result<(), RunError> {
    let text = match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return write_page(path, &page()?),
        read => read.map_err(RunError::reading(path))?,
    };
    let text = String::from_utf8(text).unwrap_or_default();
    let page = text.rfind(BEFORE).map(|at| &text[..at]);
    if page.is_some_and(|page| sealed(page) == text) {
        return Ok(());
    }
    Err(RunError::Changed {
        file: path.to_owned(),
    })
}

/// Beginning of the last line of a page; the SHA-256 of all before that line follows.
const BEFORE: &str = "<!-- sha256 of all before: ";

fn sealed(page: &str) -> String {
    let mut text = page.to_owned();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    let digest = Sha256::digest(&text);
    let digits: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    text + BEFORE + &digits + " -->\n"
}
