//! A file that only grows, and what its first bytes were.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::error::RunError;

/// Bytes are handed to the operating system when so many wait.
const BATCH: usize = 1 << 16;

/// The beginning of a file that a checkpoint counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Vouched {
    /// Its length in bytes.
    pub bytes: u64,
    /// Its SHA-256.
    pub sha256: [u8; 32],
}

impl Vouched {
    /// Nothing of a file.
    pub const NOTHING: Self = Self {
        bytes: 0,
        sha256: [0; 32],
    };

    /// So many bytes with this digest.
    pub fn of(bytes: u64, digest: &Sha256) -> Self {
        Self {
            bytes,
            sha256: digest.clone().finalize().into(),
        }
    }

    /// Reads these bytes again, of a file that stands at their beginning; their digest, to be continued.
    pub fn read_again(&self, file: &mut File, path: &Path) -> Result<Sha256, RunError> {
        let counted = self.bytes;
        let (bytes, digest) = read_digest(file, counted).map_err(RunError::reading(path))?;
        let reason = if bytes < counted {
            format!("it has {bytes} bytes where the checkpoint counts {counted}")
        } else if <[u8; 32]>::from(digest.clone().finalize()) != self.sha256 {
            format!(
                "its first {counted} bytes are not those that were written: it was changed since, or damaged"
            )
        } else {
            return Ok(digest);
        };
        Err(RunError::Damaged {
            file: path.to_owned(),
            reason,
        })
    }
}

/// A file that rows are appended to, with a digest of all that was written.
pub(crate) struct Appended {
    path: PathBuf,
    file: File,
    waiting: Vec<u8>,
    bytes: u64,
    digest: Sha256,
}

/// A file of one's own in the place of whatever has its name: behind a link nothing is written.
pub(super) fn create_anew(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    File::create_new(path)
}

impl Appended {
    /// An empty file in the place of whatever has its name.
    pub fn create(path: &Path) -> Result<Self, RunError> {
        Ok(Self {
            file: create_anew(path).map_err(RunError::io(path))?,
            path: path.to_owned(),
            waiting: Vec::new(),
            bytes: 0,
            digest: Sha256::new(),
        })
    }

    /// The file of an earlier session, to be continued behind what its checkpoint counts. Nothing in it is
    /// changed before [`cut`](Self::cut) or the first byte.
    pub fn resume(path: &Path, vouched: &Vouched) -> Result<Self, RunError> {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(path)
            .map_err(RunError::resuming(path))?;
        let digest = vouched.read_again(&mut file, path)?;
        Ok(Self {
            path: path.to_owned(),
            file,
            waiting: Vec::new(),
            bytes: vouched.bytes,
            digest,
        })
    }

    /// Drops what stands behind the bytes that are counted, but for whole rows where these are to stay.
    pub fn cut(&mut self, keeps_rows: bool) -> Result<(), RunError> {
        let bytes = self.bytes;
        let mut cut = || -> io::Result<()> {
            let mut end = bytes;
            self.file.seek(SeekFrom::Start(bytes))?;
            if keeps_rows {
                let mut rest = Vec::new();
                self.file.read_to_end(&mut rest)?;
                let last = rest.iter().rposition(|byte| *byte == b'\n');
                end += last.map_or(0, |at| at as u64 + 1);
            }
            self.file.set_len(end)?;
            self.file.seek(SeekFrom::Start(bytes)).map(|_| ())
        };
        cut().map_err(RunError::io(&self.path))
    }

    /// Appends bytes.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), RunError> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= BATCH {
            self.flush()?;
        }
        Ok(())
    }

    /// Appends what a checkpoint counts of another file, but for its first `skipped` bytes.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where that file is not what was written.
    pub fn append_file(
        &mut self,
        path: &Path,
        vouched: &Vouched,
        skipped: u64,
    ) -> Result<(), RunError> {
        let mut file = File::open(path).map_err(RunError::resuming(path))?;
        vouched.read_again(&mut file, path)?;
        file.seek(SeekFrom::Start(skipped))
            .map_err(RunError::reading(path))?;
        let mut rest = file.take(vouched.bytes.saturating_sub(skipped));
        let mut buffer = vec![0; BATCH];
        loop {
            match rest.read(&mut buffer).map_err(RunError::reading(path))? {
                0 => return Ok(()),
                some => self.push(&buffer[..some])?,
            }
        }
    }

    /// Hands everything to the operating system: it survives this program.
    pub fn flush(&mut self) -> Result<(), RunError> {
        self.file
            .write_all(&self.waiting)
            .map_err(RunError::io(&self.path))?;
        self.bytes += self.waiting.len() as u64;
        self.digest.update(&self.waiting);
        self.waiting.clear();
        Ok(())
    }

    /// Hands everything to the disk, where it survives the machine; returns what a checkpoint may count.
    pub fn sync(&mut self) -> Result<Vouched, RunError> {
        self.flush()?;
        self.file.sync_data().map_err(RunError::io(&self.path))?;
        Ok(Vouched::of(self.bytes, &self.digest))
    }

    /// Makes sure that the file ends with the bytes that wait.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where it does not.
    pub fn confirm_end(&mut self) -> Result<(), RunError> {
        ends_with(&mut self.file, &self.path, self.bytes, &self.waiting)
    }

    /// Ends the file behind the last byte pushed.
    pub fn end(&mut self) -> Result<(), RunError> {
        self.flush()?;
        self.file
            .set_len(self.bytes)
            .and_then(|()| self.file.sync_data())
            .map_err(RunError::io(&self.path))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file another name, in the place of one that has it.
    pub fn rename(&mut self, path: &Path) -> Result<(), RunError> {
        fs::rename(&self.path, path).map_err(RunError::io(path))?;
        self.path = path.to_owned();
        Ok(())
    }
}

/// Refuses a file that has other bytes than `expected` behind its first `start`.
pub(super) fn ends_with(
    file: &mut File,
    path: &Path,
    start: u64,
    expected: &[u8],
) -> Result<(), RunError> {
    let mut rest = Vec::new();
    file.seek(SeekFrom::Start(start))
        .and_then(|_| file.take(expected.len() as u64 + 1).read_to_end(&mut rest))
        .map_err(RunError::reading(path))?;
    if rest == expected {
        return Ok(());
    }
    Err(RunError::Damaged {
        file: path.to_owned(),
        reason: "other data follow its last row: it was changed since, or damaged".to_owned(),
    })
}

/// How many of a file's first `count` bytes there are, and their digest.
fn read_digest(file: &mut File, count: u64) -> io::Result<(u64, Sha256)> {
    let mut digest = Sha256::new();
    let mut buffer = vec![0; BATCH];
    let (mut first, mut read) = (file.take(count), 0);
    loop {
        match first.read(&mut buffer) {
            Ok(0) => return Ok((read, digest)),
            Ok(some) => {
                digest.update(&buffer[..some]);
                read += some as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}
