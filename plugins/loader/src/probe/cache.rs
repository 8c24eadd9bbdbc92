//! Files that passed the probe before.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::file::{CheckedFile, hexadecimal};
use crate::find::user_folder;

/// A folder with one small file for each library that passed. Refusals are not kept: their cause may
/// lie outside the library, such as a missing dependency.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ProbeCache {
    folder: PathBuf,
}

/// All that has to be the same for a library to need no probe again.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Passed {
    path: PathBuf,
    length: u64,
    modified: String,
    sha256: String,
    /// The version of the program's checks.
    host: String,
}

impl ProbeCache {
    /// The cache in a folder.
    pub(crate) fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// The cache in the user's cache folder; `None` where there is no such folder.
    pub(crate) fn of_user() -> Option<Self> {
        let folder = user_folder("XDG_CACHE_HOME", ".cache")?;
        Some(Self::new(folder.join("plugins")))
    }

    /// Whether this very file passed before.
    pub(crate) fn has(&self, path: &Path, file: &CheckedFile) -> bool {
        let Ok(text) = fs::read_to_string(self.entry(path)) else {
            return false;
        };
        serde_json::from_str(&text).is_ok_and(|known: Passed| known == passed(path, file))
    }

    /// Notes that a file passed. A cache that cannot be written costs time at the next start only.
    pub(crate) fn add(&self, path: &Path, file: &CheckedFile) {
        let write = || -> std::io::Result<()> {
            fs::create_dir_all(&self.folder)?;
            let entry = self.entry(path);
            let partial = entry.with_extension(format!("{}.part", std::process::id()));
            fs::write(&partial, serde_json::to_string(&passed(path, file))?)?;
            fs::rename(partial, entry)
        };
        drop(write());
    }

    fn entry(&self, path: &Path) -> PathBuf {
        let digest = Sha256::digest(path.as_os_str().as_encoded_bytes());
        let name = hexadecimal(&digest[..16]);
        self.folder.join(format!("{name}.json"))
    }
}

fn passed(path: &Path, file: &CheckedFile) -> Passed {
    Passed {
        path: path.to_owned(),
        length: file.length,
        modified: file.modified.to_string(),
        sha256: file.sha256.clone(),
        host: env!("CARGO_PKG_VERSION").to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_or_moved_file_is_tried_again() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = ProbeCache::new(folder.path().join("below"));
        let path = Path::new("/somewhere/libacme.so");
        let file = CheckedFile {
            sha256: "00ff".to_owned(),
            length: 12,
            modified: 34,
            identity: (1, 2, 3),
        };
        assert!(!cache.has(path, &file));
        cache.add(path, &file);
        assert!(cache.has(path, &file));
        assert!(!cache.has(Path::new("/elsewhere/libacme.so"), &file));
        for change in [
            |file: &mut CheckedFile| file.length += 1,
            |file: &mut CheckedFile| file.modified += 1,
            |file: &mut CheckedFile| file.sha256.push('0'),
        ] {
            let mut changed = file.clone();
            change(&mut changed);
            assert!(!cache.has(path, &changed));
        }
    }
}
