//! Files that a command writes.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// Writes a file.
///
/// # Errors
/// [`Failure::File`].
pub fn write(file: &Path, text: &str) -> Result<(), Failure> {
    fs::write(file, text).map_err(failed(file))
}

/// Replaces a file in one operation, so that a full disk costs nothing; its permissions stay.
///
/// # Errors
/// [`Failure::File`].
pub fn replace(file: &Path, text: &str) -> Result<(), Failure> {
    // Behind a symbolic link the file itself is replaced, not the link.
    let target = fs::canonicalize(file).map_err(failed(file))?;
    let mut name = target.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    let temporary = target.with_file_name(name);
    let written = fs::write(&temporary, text)
        .and_then(|()| fs::set_permissions(&temporary, fs::metadata(&target)?.permissions()))
        .and_then(|()| fs::rename(&temporary, &target));
    written.map_err(|source| {
        let _ = fs::remove_file(&temporary);
        failed(file)(source)
    })
}

/// Makes a directory, before the work whose results it is to hold.
///
/// # Errors
/// [`Failure::File`].
pub fn make_directory(directory: &Path) -> Result<(), Failure> {
    fs::create_dir_all(directory).map_err(failed(directory))
}

/// Refuses a file that could not be written later, before the work whose result it is to hold.
///
/// # Errors
/// [`Failure::File`].
pub fn check_writable(file: &Path) -> Result<(), Failure> {
    let known = fs::metadata(file).ok();
    if known
        .as_ref()
        .is_some_and(|known| known.permissions().readonly())
    {
        return Err(failed(file)(io::Error::new(
            io::ErrorKind::PermissionDenied,
            "it is read-only",
        )));
    }
    let opened = fs::File::options().append(true).create(true).open(file);
    opened.map_err(failed(file))?;
    if known.is_none() {
        let _ = fs::remove_file(file);
    }
    Ok(())
}

fn failed(file: &Path) -> impl FnOnce(io::Error) -> Failure {
    let file: PathBuf = file.to_owned();
    move |source| Failure::File {
        action: "write",
        file,
        source,
    }
}
