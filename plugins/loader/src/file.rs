//! Checks of the file itself, before anything of it is run.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::error::Refusal;
use crate::object;
use crate::platform;

/// A file that passed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CheckedFile {
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// Its length in bytes.
    pub length: u64,
    /// When it was last changed, in nanoseconds since 1970; 0 where the system does not say.
    pub modified: u128,
    /// Which file it is, and when anything of it was last changed, its names included.
    pub identity: (u64, u64, i128),
}

/// Why a file cannot be looked at.
pub(crate) fn unreadable(error: io::Error) -> Refusal {
    match error.kind() {
        io::ErrorKind::NotFound => Refusal::NoSuchFile,
        _ => Refusal::Unreadable {
            message: error.to_string(),
        },
    }
}

/// Checks that nobody but root and this user may change the target of an absolute path. It checks the file, every
/// folder and link on the way, and those that a link leads through.
pub(crate) fn check_way(path: &Path) -> Result<(), Refusal> {
    /// As many links as the system follows.
    const MOST_LINKS: usize = 40;
    let mut place = PathBuf::new();
    let mut rest: Vec<PathBuf> = reversed(path);
    let mut links = 0;
    while let Some(piece) = rest.pop() {
        if piece == Path::new("..") {
            place.pop();
            continue;
        }
        let next = place.join(&piece);
        let metadata = fs::symlink_metadata(&next).map_err(unreadable)?;
        if let Some(owner) = platform::other_owner(&metadata) {
            return Err(Refusal::OwnedByOther { place: next, owner });
        }
        if metadata.is_symlink() {
            links += 1;
            if links > MOST_LINKS {
                return Err(Refusal::Unreadable {
                    message: "its path goes through too many links".to_owned(),
                });
            }
            let target = fs::read_link(&next).map_err(unreadable)?;
            rest.extend(reversed(&target));
            continue;
        }
        if let Some((who, mode)) = platform::other_writers(&metadata) {
            return Err(Refusal::WritableByOthers {
                place: next,
                mode,
                who: who.to_owned(),
            });
        }
        place = next;
    }
    Ok(())
}

/// The pieces of a path, the last one first; the root is one of them.
fn reversed(path: &Path) -> Vec<PathBuf> {
    let pieces = path.components().rev();
    pieces
        .map(|piece| PathBuf::from(piece.as_os_str()))
        .collect()
}

/// Checks that `path` (absolute, without links) is a regular file that nobody but its owner may
/// replace, a shared library for this machine, and the one that was meant.
pub(crate) fn check(path: &Path, expected: Option<&str>) -> Result<CheckedFile, Refusal> {
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(Refusal::NotAFile);
    }
    check_way(path)?;
    let mut file = File::open(path).map_err(unreadable)?;
    let mut head = Vec::with_capacity(object::HEAD);
    let mut taken = file.by_ref().take(object::HEAD as u64);
    taken.read_to_end(&mut head).map_err(unreadable)?;
    object::check(&head)?;
    let sha256 = hash(&head, &mut file).map_err(unreadable)?;
    if let Some(expected) = expected
        && !expected.eq_ignore_ascii_case(&sha256)
    {
        return Err(Refusal::Hash {
            expected: expected.to_owned(),
            found: sha256,
        });
    }
    let modified = metadata.modified().ok();
    let since = modified.and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok());
    Ok(CheckedFile {
        sha256,
        length: metadata.len(),
        modified: since.map_or(0, |since| since.as_nanos()),
        identity: platform::state(&metadata),
    })
}

/// The SHA-256 of a beginning and the rest of a file, in hexadecimal.
fn hash(head: &[u8], rest: &mut File) -> io::Result<String> {
    let mut hasher = Sha256::new();
    hasher.update(head);
    let mut buffer = vec![0; 1 << 16];
    loop {
        match rest.read(&mut buffer)? {
            0 => break,
            read => hasher.update(&buffer[..read]),
        }
    }
    Ok(hexadecimal(&hasher.finalize()))
}

/// Bytes as two digits each.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-4's example of one block, cut between head and rest.
    #[test]
    fn the_hash_is_that_of_the_whole_file() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rest");
        fs::write(&path, "bc").expect("a writable folder");
        let mut rest = File::open(path).expect("the file");
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(hash(b"a", &mut rest).expect("readable"), expected);
    }

    #[cfg(unix)]
    #[test]
    fn whatever_others_may_write_is_refused_up_to_the_root() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let inner = folder
            .path()
            .canonicalize()
            .expect("it is there")
            .join("inner");
        fs::create_dir(&inner).expect("a writable folder");
        let path = inner.join("plugin.so");
        fs::write(&path, "text").expect("a writable folder");
        let mode = |place: &Path, mode| {
            fs::set_permissions(place, fs::Permissions::from_mode(mode)).expect("our own file");
        };
        let who = |path: &Path| match check(path, None) {
            Err(Refusal::WritableByOthers { place, who, mode }) => Some((place, who, mode)),
            _ => None,
        };
        mode(&inner, 0o755);
        for (bits, expected) in [(0o666, "everyone"), (0o664, "its group")] {
            mode(&path, bits);
            assert_eq!(who(&path), Some((path.clone(), expected.to_owned(), bits)));
        }
        mode(&path, 0o644);
        mode(&inner, 0o777);
        assert_eq!(
            who(&path),
            Some((inner.clone(), "everyone".to_owned(), 0o777))
        );
        // A link in such a folder may be changed to lead elsewhere, whatever it leads to now.
        let (open, good) = (inner.join("open"), inner.join("good"));
        fs::create_dir(&open).expect("a writable folder");
        fs::create_dir(&good).expect("a writable folder");
        fs::write(good.join("plugin.so"), "text").expect("a writable folder");
        for (folder, bits) in [(&open, 0o777), (&good, 0o755), (&inner, 0o755)] {
            mode(folder, bits);
        }
        std::os::unix::fs::symlink("../good", open.join("way")).expect("a link");
        let link = open.join("way/plugin.so");
        assert!(matches!(
            check_way(&link),
            Err(Refusal::WritableByOthers { place, .. }) if place == open
        ));
        mode(&open, 0o755);
        assert_eq!(check_way(&link), Ok(()));
        // What belongs to another user may be changed by them; only root can make such a file here.
        if std::os::unix::fs::chown(good.join("plugin.so"), Some(12_345), None).is_ok() {
            assert_eq!(
                check_way(&link),
                Err(Refusal::OwnedByOther {
                    place: good.join("plugin.so"),
                    owner: 12_345
                })
            );
        }
        // In a folder like /tmp nobody replaces the files of others.
        mode(&inner, 0o1777);
        assert_eq!(who(&path), None);
        mode(&inner, 0o755);
        assert!(matches!(
            check(&path, None),
            Err(Refusal::NotALibrary { .. })
        ));
        assert_eq!(check(&inner, None), Err(Refusal::NotAFile));
        assert_eq!(check(&inner.join("none"), None), Err(Refusal::NoSuchFile));
    }
}
