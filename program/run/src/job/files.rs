//! Files that wait aside until they are taken in.

use std::fs;
use std::io;
use std::path::Path;

/// Name of the file in which a member's rows wait when they are many, before and behind the member's number:
/// `section-17.part`.
pub(crate) const PART: (&str, &str) = ("section-", ".part");

/// Removes the parts of members' rows that a killed session has left.
pub(crate) fn remove_parts(directory: &Path) -> io::Result<()> {
    let (before, behind) = PART;
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let number = name
            .strip_prefix(before)
            .and_then(|name| name.strip_suffix(behind));
        if number.is_some_and(|number| number.parse::<u64>().is_ok()) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}
