//! A file that is replaced as a whole.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use super::appended::create_anew;
use super::error::RunError;

/// The extension of a file that is written to take the place of another.
pub(crate) const UNFINISHED: &str = "new";

/// Replaces `path` in one operation: readers see the old content or the new.
pub(crate) fn replace(path: &Path, content: &[u8]) -> Result<(), RunError> {
    let temporary = path.with_extension(UNFINISHED);
    let written = write_whole(&temporary, content).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|source| {
        // What a full disk has no room for does not stay there either.
        let _ = fs::remove_file(&temporary);
        RunError::io(path)(source)
    })
}

/// Makes sure that a file has this content; one that is not there is written.
///
/// # Errors
/// [`RunError::Changed`] where it has another.
pub(crate) fn confirm(path: &Path, content: &[u8]) -> Result<(), RunError> {
    match fs::read(path) {
        Ok(found) if found == content => Ok(()),
        Ok(_) => Err(RunError::Changed {
            file: path.to_owned(),
        }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => replace(path, content),
        Err(error) => Err(RunError::reading(path)(error)),
    }
}

fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = create_anew(path)?;
    file.write_all(content)?;
    file.sync_data()
}
