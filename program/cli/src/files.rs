//! Files that a command writes.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use leafwise::scene::json::pretty;
use serde::Serialize;

use crate::failure::Failure;

/// Writes a file.
///
/// # Errors
/// [`Failure::File`].
pub fn write(file: &Path, text: &str) -> Result<(), Failure> {
    fs::write(file, text).map_err(failed(file))
}

/// Refuses a file that exists, before work is done for it; `help` says how to name another.
///
/// # Errors
/// [`Failure::Usage`].
pub fn refuse_existing(file: &Path, help: &str) -> Result<(), Failure> {
    match file.exists() {
        true => Err(exists(file, help)),
        false => Ok(()),
    }
}

fn exists(file: &Path, help: &str) -> Failure {
    Failure::usage(
        format!("{} exists and is left as it is", file.display()),
        help,
    )
}

/// Writes a file that does not exist; `help` says how to name another.
///
/// # Errors
/// [`Failure::Usage`] where it exists, [`Failure::File`].
pub fn write_new(file: &Path, content: impl AsRef<[u8]>, help: &str) -> Result<(), Failure> {
    let written = fs::File::create_new(file).and_then(|mut open| open.write_all(content.as_ref()));
    written.map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => exists(file, help),
        _ => failed(file)(source),
    })
}

/// Writes a value as JSON.
///
/// # Errors
/// [`Failure::File`].
pub fn write_json(file: &Path, value: &impl Serialize) -> Result<(), Failure> {
    let text = pretty(value).map_err(failed(file))?;
    write(file, &format!("{text}\n"))
}

/// Replaces a file in one operation and hands it to the disk, so that neither a full disk nor a lost
/// machine costs anything; its permissions stay.
///
/// # Errors
/// [`Failure::File`].
pub fn replace(file: &Path, text: &str) -> Result<(), Failure> {
    // Behind a symbolic link the file itself is replaced, not the link.
    let target = fs::canonicalize(file).map_err(failed(file))?;
    let mut name = target.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    let temporary = target.with_file_name(name);
    let written = write_to_disk(&temporary, text)
        .and_then(|()| fs::set_permissions(&temporary, fs::metadata(&target)?.permissions()))
        .and_then(|()| fs::rename(&temporary, &target));
    written.map_err(|source| {
        let _ = fs::remove_file(&temporary);
        failed(file)(source)
    })
}

/// Replaces a file whose content is still `before`; says whether it was.
///
/// # Errors
/// [`Failure::File`].
pub fn replace_unchanged(file: &Path, before: &[u8], text: &str) -> Result<bool, Failure> {
    if fs::read(file).map_err(failed(file))? != before {
        return Ok(false);
    }
    replace(file, text).map(|()| true)
}

/// A new file in the place of whatever has its name: behind a link nothing is written.
fn write_to_disk(file: &Path, text: &str) -> io::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut new = fs::File::create_new(file)?;
    new.write_all(text.as_bytes())?;
    new.sync_all()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_edited_meanwhile_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("scene.toml");
        fs::write(&file, "edited").expect("writable");
        let is_replaced = |before: &[u8]| replace_unchanged(&file, before, "new").expect("a file");
        assert!(!is_replaced(b"as read"));
        assert_eq!(fs::read(&file).expect("a file"), b"edited");
        assert!(is_replaced(b"edited"));
        assert_eq!(fs::read(&file).expect("a file"), b"new");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }
}
