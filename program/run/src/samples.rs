//! Recorded states, appended to `samples.csv`, and those on a section, appended to `section.csv`.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use super::appended::{Appended, Vouched};
use super::csv::{Table, numbers};
use super::error::RunError;

/// The file's name in the run directory, and before it is published.
pub(super) const FILE: &str = "samples.csv";
pub(super) const UNPUBLISHED: &str = "samples.new";

/// The states on a section.
pub(super) const SECTION: &str = "section.csv";

/// The writer of such a file: a header, then one row for each sample, shortest decimals that
/// read back as the same doubles.
pub(super) struct Samples {
    file: Appended,
    row: Table,
    count: u64,
}

impl Samples {
    /// A new file with its header.
    pub fn create(path: &Path, header: &str) -> Result<Self, RunError> {
        let mut file = Appended::create(path)?;
        file.push(header.as_bytes())?;
        Ok(Self {
            file,
            row: Table::default(),
            count: 0,
        })
    }

    /// Hands all rows to the disk and gives the file another name, in the place of one with the same rows
    /// that a session left which was killed before its first checkpoint.
    pub fn publish(&mut self, path: &Path) -> Result<(), RunError> {
        self.file.sync()?;
        self.file.rename(path)
    }

    /// The file of an earlier session, to be continued behind the rows that its checkpoint counts.
    pub fn resume(path: &Path, vouched: &Vouched, count: u64) -> Result<Self, RunError> {
        Ok(Self {
            file: Appended::resume(path, vouched)?,
            row: Table::default(),
            count,
        })
    }

    /// Prepares the file of an earlier session for more rows.
    ///
    /// Whole rows behind the checkpoint stay where the plan is the same: its steps write the same
    /// bytes over them, so that a sample once on disk is there at every moment, however often the
    /// run is killed. Where the plan is longer, the last of them may be one that only the end of
    /// the shorter run asked for.
    pub fn go_on(&mut self, has_same_plan: bool) -> Result<(), RunError> {
        self.file.cut(has_same_plan)
    }

    /// Appends one row.
    pub fn push(&mut self, time: f64, state: &[f64], observables: &[f64]) -> Result<(), RunError> {
        self.row.clear();
        let values = state.iter().chain(observables).copied();
        self.row.number(time).numbers(values).end_row();
        self.count += 1;
        self.file.push(self.row.as_str().as_bytes())
    }

    /// Hands all rows to the operating system: they survive this program.
    pub fn flush(&mut self) -> Result<(), RunError> {
        self.file.flush()
    }

    /// Hands all rows to the disk: they survive the machine.
    pub fn sync(&mut self) -> Result<Vouched, RunError> {
        self.file.sync()
    }

    /// Ends the file after the last row pushed.
    pub fn end(&mut self) -> Result<(), RunError> {
        self.file.end()
    }

    /// Refuses a file that does not end with the row that waits, if one does.
    pub fn confirm_end(&mut self) -> Result<(), RunError> {
        self.file.confirm_end()
    }

    /// Rows pushed.
    pub fn count(&self) -> u64 {
        self.count
    }
}

/// Whether a directory holds no sample but the first: what a session leaves that was killed before its
/// first checkpoint.
pub(super) fn has_begun_at_most(directory: &Path, header: &str) -> bool {
    match rows_behind(&directory.join(FILE), header) {
        Ok(lines) => lines.take(2).count() <= 1,
        Err(_) => !directory.join(FILE).exists(),
    }
}

/// The first `count` rows of such a file as numbers, every `stride`-th and the last.
pub(super) fn read(
    path: &Path,
    header: &str,
    count: u64,
    stride: usize,
) -> io::Result<Vec<Vec<f64>>> {
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    let mut lines = rows_behind(path, header)?.take(count);
    let mut rows = Vec::new();
    let mut last: Option<String> = None;
    let mut at = 0_usize;
    while let Some(line) = lines.next().transpose()? {
        last = if at.is_multiple_of(stride) {
            rows.push(numbers(&line).collect());
            None
        } else {
            Some(line)
        };
        at += 1;
    }
    rows.extend(last.map(|line| numbers(&line).collect::<Vec<f64>>()));
    Ok(rows)
}

/// The lines behind the headings, which may themselves be several lines.
fn rows_behind(path: &Path, header: &str) -> io::Result<io::Lines<BufReader<File>>> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(header.len() as u64))?;
    Ok(BufReader::new(file).lines())
}

/// For each of `columns` columns from `start` on, the time of its first value that is not finite, in the
/// first `count` rows of `samples.csv`.
pub(super) fn first_undefined(
    directory: &Path,
    header: &str,
    count: u64,
    start: usize,
    columns: usize,
) -> io::Result<Vec<Option<f64>>> {
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    let mut found = vec![None; columns];
    for line in rows_behind(&directory.join(FILE), header)?.take(count) {
        let line = line?;
        // No other cell has such letters.
        if !line.contains("NaN") && !line.contains("inf") {
            continue;
        }
        let time = numbers(&line).next();
        for (first, value) in found.iter_mut().zip(numbers(&line).skip(start)) {
            if first.is_none() && !value.is_finite() {
                *first = time;
            }
        }
    }
    Ok(found)
}
