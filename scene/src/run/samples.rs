//! Recorded states, appended to `samples.csv`.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::error::RunError;

/// States of more coordinates than this are not written out at every sample.
pub(super) const WIDEST_STATE: usize = 64;

/// Rows are handed to the operating system when this many bytes wait.
const BATCH: usize = 1 << 16;

/// The file's name in the run directory.
pub(super) const FILE: &str = "samples.csv";

/// The writer of `samples.csv`: a header, then one row for each sample, shortest decimals that
/// read back as the same doubles.
pub(super) struct Samples {
    path: PathBuf,
    file: File,
    waiting: String,
    bytes: u64,
    count: u64,
}

impl Samples {
    /// A new file with its header, which takes its name when it is
    /// [`published`](Self::publish).
    pub fn create(directory: &Path, columns: &[String]) -> Result<Self, RunError> {
        let path = directory.join(FILE);
        let file = File::create(unpublished(&path)).map_err(RunError::io(&path))?;
        let mut samples = Self {
            path,
            file,
            waiting: String::new(),
            bytes: 0,
            count: 0,
        };
        let header: Vec<String> = columns.iter().map(|column| quoted(column)).collect();
        samples.waiting.push_str(&header.join(","));
        samples.waiting.push('\n');
        Ok(samples)
    }

    /// Hands all rows to the disk and gives the file its name, in the place of one with the same rows
    /// that a session left which was killed before its first checkpoint.
    pub fn publish(&mut self) -> Result<(), RunError> {
        self.sync()?;
        fs::rename(unpublished(&self.path), &self.path).map_err(RunError::io(&self.path))
    }

    /// The file of an earlier session, to be continued after the `bytes` that its checkpoint vouches
    /// for.
    ///
    /// Whole rows behind them stay: the same steps write the same bytes over them, so that a sample
    /// once on disk is there at every moment, however often the run is killed.
    pub fn resume(directory: &Path, bytes: u64, count: u64) -> Result<Self, RunError> {
        let path = directory.join(FILE);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(&path)
            .map_err(RunError::resuming(&path))?;
        let length = file.metadata().map_err(RunError::io(&path))?.len();
        if length < bytes {
            return Err(RunError::Damaged {
                file: path,
                reason: format!("it has {length} bytes where the checkpoint counts {bytes}"),
            });
        }
        let whole_rows = |file: &mut File| -> io::Result<()> {
            let mut rest = Vec::new();
            file.seek(SeekFrom::Start(bytes))?;
            file.read_to_end(&mut rest)?;
            let end = rest.iter().rposition(|byte| *byte == b'\n');
            file.set_len(bytes + end.map_or(0, |at| at as u64 + 1))?;
            file.seek(SeekFrom::Start(bytes)).map(|_| ())
        };
        whole_rows(&mut file).map_err(RunError::io(&path))?;
        Ok(Self {
            path,
            file,
            waiting: String::new(),
            bytes,
            count,
        })
    }

    /// Appends one row.
    pub fn push(&mut self, time: f64, state: &[f64], observables: &[f64]) -> Result<(), RunError> {
        // Writing to a string cannot fail.
        let _ = write!(self.waiting, "{time:?}");
        for value in state.iter().chain(observables) {
            let _ = write!(self.waiting, ",{value:?}");
        }
        self.waiting.push('\n');
        self.count += 1;
        if self.waiting.len() >= BATCH {
            self.flush()
        } else {
            Ok(())
        }
    }

    /// Hands all rows to the operating system: they survive this program.
    pub fn flush(&mut self) -> Result<(), RunError> {
        self.file
            .write_all(self.waiting.as_bytes())
            .map_err(RunError::io(&self.path))?;
        self.bytes += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(())
    }

    /// Hands all rows to the disk: they survive the machine.
    pub fn sync(&mut self) -> Result<(), RunError> {
        self.flush()?;
        self.file.sync_data().map_err(RunError::io(&self.path))
    }

    /// Ends the file after the last row pushed.
    pub fn end(&mut self) -> Result<(), RunError> {
        self.flush()?;
        self.file
            .set_len(self.bytes)
            .and_then(|()| self.file.sync_data())
            .map_err(RunError::io(&self.path))
    }

    /// Bytes handed over, and rows pushed.
    pub fn position(&self) -> (u64, u64) {
        (self.bytes, self.count)
    }
}

fn unpublished(path: &Path) -> PathBuf {
    path.with_extension("new")
}

/// Whether a directory holds no sample but the first: what a session leaves that was killed before its
/// first checkpoint.
pub(super) fn has_begun_at_most(directory: &Path) -> bool {
    match File::open(directory.join(FILE)) {
        Ok(file) => BufReader::new(file).lines().take(3).count() <= 2,
        Err(_) => !directory.join(FILE).exists(),
    }
}

/// The first `count` rows of `samples.csv` as numbers, every `stride`-th and the last.
pub(super) fn read(directory: &Path, count: u64, stride: usize) -> io::Result<Vec<Vec<f64>>> {
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    let mut lines = BufReader::new(File::open(directory.join(FILE))?)
        .lines()
        .skip(1)
        .take(count);
    let parse = |line: &str| -> Vec<f64> {
        line.split(',')
            .map(|cell| cell.parse().unwrap_or(f64::NAN))
            .collect()
    };
    let mut rows = Vec::new();
    let mut last: Option<String> = None;
    let mut at = 0_usize;
    while let Some(line) = lines.next().transpose()? {
        last = if at.is_multiple_of(stride) {
            rows.push(parse(&line));
            None
        } else {
            Some(line)
        };
        at += 1;
    }
    rows.extend(last.as_deref().map(parse));
    Ok(rows)
}

/// A heading, in quotes where it holds a comma or a quote.
pub(crate) fn quoted(column: &str) -> String {
    if column.contains([',', '"']) {
        format!("\"{}\"", column.replace('"', "\"\""))
    } else {
        column.to_owned()
    }
}
