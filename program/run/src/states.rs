//! Recorded states too wide for `samples.csv`, as `states.npy`.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::appended::{Vouched, create_anew, ends_with};
use super::error::RunError;

/// The file's name in the run directory.
pub(super) const FILE: &str = "states.npy";

/// The file of the last state, which samples do not hold then.
pub(super) const FINAL_STATE: &str = "final_state.bin";

/// Rows are handed to the operating system when this many bytes wait.
const BATCH: usize = 1 << 20;

/// The length of the header, whatever the number of rows.
pub(crate) const HEADER: usize = 128;

/// The writer of `states.npy`: a matrix of doubles, a row for each row of `samples.csv`, in the format 1.0
/// of NumPy (numpy.lib.format). The header counts the rows behind it at every moment.
pub(super) struct StateTable {
    path: PathBuf,
    file: File,
    width: usize,
    waiting: Vec<u8>,
    /// Rows handed over, and rows that the header counts.
    rows: u64,
    counted: u64,
    /// Of the rows handed over.
    digest: Sha256,
    /// Nothing is appended any more.
    is_frozen: bool,
}

impl StateTable {
    /// A new file without rows.
    pub fn create(directory: &Path, width: usize) -> Result<Self, RunError> {
        let path = directory.join(FILE);
        let temporary = path.with_extension("new");
        let create = || {
            let mut file = create_anew(&temporary)?;
            file.write_all(&header(0, width))?;
            fs::rename(&temporary, &path)?;
            Ok(file)
        };
        let file = create().map_err(RunError::io(&path))?;
        Ok(Self {
            path,
            file,
            width,
            waiting: Vec::new(),
            rows: 0,
            counted: 0,
            digest: Sha256::new(),
            is_frozen: false,
        })
    }

    /// The file of an earlier session, to be continued behind the rows that its checkpoint vouches for.
    /// Whole rows behind them stay: the same steps write the same bytes over them.
    pub fn resume(directory: &Path, width: usize, vouched: &Vouched) -> Result<Self, RunError> {
        let path = directory.join(FILE);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(&path)
            .map_err(RunError::resuming(&path))?;
        let rows = vouched.bytes / (8 * width as u64);
        let mut head = [0; HEADER];
        let counts = file
            .read_exact(&mut head)
            .ok()
            .and_then(|()| counted(&head));
        // Rows are counted before a checkpoint vouches for them.
        let Some(counted) = counts.filter(|k| *k >= rows && header(*k, width) == head) else {
            return Err(RunError::Damaged {
                file: path,
                reason: format!("its header is not that of {rows} rows or more of {width} numbers"),
            });
        };
        let digest = vouched.read_again(&mut file, &path)?;
        Ok(Self {
            path,
            file,
            width,
            waiting: Vec::new(),
            rows,
            counted,
            digest,
            is_frozen: false,
        })
    }

    /// Prepares the file of an earlier session for more rows. Where the plan is longer, the last of those
    /// behind the checkpoint may be one that only the end of the shorter run asked for: they go. So do
    /// all where a machine went down with the header on its disk and the rows not.
    pub fn go_on(&mut self, has_same_plan: bool) -> Result<(), RunError> {
        let length = self
            .file
            .metadata()
            .map_err(RunError::io(&self.path))?
            .len();
        let present = length.saturating_sub(HEADER as u64) / (8 * self.width as u64);
        if has_same_plan && self.counted <= present {
            return Ok(());
        }
        self.count(self.rows)?;
        self.file
            .set_len(self.length())
            .map_err(RunError::io(&self.path))
    }

    /// Leaves the file as it is, whatever is pushed.
    pub fn freeze(&mut self) {
        self.is_frozen = true;
    }

    /// Makes sure that the file ends with the rows that wait, and counts them.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where it does not.
    pub fn confirm_end(&mut self) -> Result<(), RunError> {
        let rows = self.rows + (self.waiting.len() / (8 * self.width)) as u64;
        if self.counted != rows {
            return Err(RunError::Damaged {
                file: self.path.clone(),
                reason: format!("its header counts {} rows of {rows}", self.counted),
            });
        }
        let start = self.length();
        ends_with(&mut self.file, &self.path, start, &self.waiting)
    }

    /// The bytes of the header and of the rows handed over.
    fn length(&self) -> u64 {
        HEADER as u64 + 8 * self.width as u64 * self.rows
    }

    /// Appends one row.
    pub fn push(&mut self, row: impl Iterator<Item = f64>) -> Result<(), RunError> {
        row.for_each(|value| self.waiting.extend_from_slice(&value.to_le_bytes()));
        match self.waiting.len() >= BATCH && !self.is_frozen {
            true => self.flush(),
            false => Ok(()),
        }
    }

    /// Hands all rows to the operating system, then counts them in the header.
    pub fn flush(&mut self) -> Result<(), RunError> {
        let written = (self.waiting.len() / (8 * self.width)) as u64;
        self.file
            .write_all(&self.waiting)
            .map_err(RunError::io(&self.path))?;
        self.digest.update(&self.waiting);
        self.waiting.clear();
        self.rows += written;
        if self.rows > self.counted {
            self.count(self.rows)?;
        }
        Ok(())
    }

    /// Hands all rows to the disk; returns what a checkpoint may count of the bytes behind the header.
    pub fn sync(&mut self) -> Result<Vouched, RunError> {
        self.flush()?;
        self.file.sync_data().map_err(RunError::io(&self.path))?;
        Ok(Vouched::of(self.length() - HEADER as u64, &self.digest))
    }

    /// Ends the file after the last row pushed.
    pub fn end(&mut self) -> Result<(), RunError> {
        self.flush()?;
        self.count(self.rows)?;
        self.file
            .set_len(self.length())
            .and_then(|()| self.file.sync_data())
            .map_err(RunError::io(&self.path))
    }

    fn count(&mut self, rows: u64) -> Result<(), RunError> {
        let end = self.length();
        let header = header(rows, self.width);
        let mut rewrite = || {
            self.file.seek(SeekFrom::Start(0))?;
            self.file.write_all(&header)?;
            self.file.seek(SeekFrom::Start(end)).map(drop)
        };
        rewrite().map_err(RunError::io(&self.path))?;
        self.counted = rows;
        Ok(())
    }
}

/// Magic, version 1.0, the length of what follows, and a Python dictionary filled up with spaces.
pub(crate) fn header(rows: u64, width: usize) -> [u8; HEADER] {
    let dictionary =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {width}), }}");
    let mut header = [b' '; HEADER];
    header[..8].copy_from_slice(b"\x93NUMPY\x01\x00");
    header[8..10].copy_from_slice(&(HEADER as u16 - 10).to_le_bytes());
    header[10..10 + dictionary.len()].copy_from_slice(dictionary.as_bytes());
    header[HEADER - 1] = b'\n';
    header
}

/// The rows that a header counts.
fn counted(header: &[u8; HEADER]) -> Option<u64> {
    let text = std::str::from_utf8(&header[10..]).ok()?;
    let (_, shape) = text.split_once("'shape': (")?;
    shape.split_once(',')?.0.parse().ok()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{FILE, HEADER, StateTable, Vouched};

    fn rows(bytes: &[u8]) -> Vec<f64> {
        let values = bytes[HEADER..].chunks_exact(8);
        values
            .map(|b| f64::from_le_bytes(b.try_into().expect("eight")))
            .collect()
    }

    #[test]
    fn the_header_is_numpys_and_counts_the_rows() {
        let root = tempfile::tempdir().expect("a directory");
        let mut table = StateTable::create(root.path(), 2).expect("a file");
        table.push([1.0, -0.0].into_iter()).expect("a row");
        table.push([2.5, 1e-300].into_iter()).expect("a row");
        table.end().expect("the end");
        let bytes = fs::read(root.path().join(FILE)).expect("a file");
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        let text = std::str::from_utf8(&bytes[10..HEADER]).expect("ASCII");
        let dictionary = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }";
        assert_eq!(text.trim_end(), dictionary);
        assert!(text.ends_with(" \n"));
        let values = rows(&bytes);
        assert_eq!(values, [1.0, 0.0, 2.5, 1e-300]);
        assert!(values[1].is_sign_negative());
    }

    /// Rows of three; what a checkpoint vouches for after two of them, and after all.
    fn five_rows(directory: &std::path::Path) -> [Vouched; 2] {
        let mut table = StateTable::create(directory, 3).expect("a file");
        let mut vouched = [Vouched::NOTHING; 2];
        for k in 0..5 {
            let row = (0..3).map(|i| f64::from(10 * k + i));
            table.push(row).expect("a row");
            vouched[usize::from(k > 1)] = table.sync().expect("written");
        }
        table.end().expect("the end");
        vouched
    }

    #[test]
    fn a_flipped_bit_in_any_byte_is_refused() {
        let root = tempfile::tempdir().expect("a directory");
        let path = root.path().join(FILE);
        let [_, all] = five_rows(root.path());
        let good = fs::read(&path).expect("a file");
        for at in 0..good.len() {
            let mut flipped = good.clone();
            flipped[at] ^= 1 << (at % 8);
            fs::write(&path, &flipped).expect("writable");
            let resumed = StateTable::resume(root.path(), 3, &all);
            assert!(
                resumed.and_then(|mut table| table.confirm_end()).is_err(),
                "byte {at}"
            );
            assert!(fs::read(&path).expect("a file") == flipped, "byte {at}");
        }
        fs::write(&path, &good).expect("writable");
        let mut whole = StateTable::resume(root.path(), 3, &all).expect("as it was");
        whole.confirm_end().expect("as it was");
    }

    #[test]
    fn rows_behind_the_checkpoint_stay_until_the_same_are_written_over_them() {
        let root = tempfile::tempdir().expect("a directory");
        let path = root.path().join(FILE);
        let [two, all] = five_rows(root.path());
        let expected = fs::read(&path).expect("a file");
        // Killed in the midst of the fifth row, with a checkpoint after the second.
        let killed = &expected[..expected.len() - 5];
        fs::write(&path, killed).expect("writable");
        let mut again = StateTable::resume(root.path(), 3, &two).expect("a file");
        for k in 2..5 {
            assert!(fs::read(&path).expect("a file").len() >= expected.len() - 5);
            again
                .push((0..3).map(|i| f64::from(10 * k + i)))
                .expect("a row");
            again.flush().expect("written");
        }
        again.end().expect("the end");
        assert!(fs::read(&path).expect("a file") == expected);
        fs::write(&path, killed).expect("writable");
        assert!(StateTable::resume(root.path(), 3, &all).is_err());
    }
}
