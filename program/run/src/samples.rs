//! Recorded states, appended to `samples.csv`, and those on a section, appended to `section.csv`; or both in memory.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use super::appended::{Appended, Vouched};
use super::csv::{Table, numbers};
use super::error::RunError;
use super::room::{make_room, with_room};

/// The file's name in the run directory, and before it is published.
pub(super) const FILE: &str = "samples.csv";
pub(super) const UNPUBLISHED: &str = "samples.new";

/// The states on a section.
pub(super) const SECTION: &str = "section.csv";

/// Rows of a time, recorded coordinates and observables.
pub(super) struct Samples {
    rows: Rows,
    count: u64,
}

/// Where rows are kept.
enum Rows {
    /// Behind so many bytes of headings, as shortest decimals that read back as the same doubles.
    File {
        file: Appended,
        headings: u64,
        row: Table,
    },
    /// One after the other, each of so many doubles.
    Memory { values: Vec<f64>, width: usize },
}

impl Samples {
    /// A new file with its header.
    pub fn create(path: &Path, header: &str) -> Result<Self, RunError> {
        let mut file = Appended::create(path)?;
        file.push(header.as_bytes())?;
        Ok(Self::of_file(file, header, 0))
    }

    /// Rows of so many numbers in memory, with room for so many of them.
    pub fn in_memory(width: usize, rows: u64) -> Result<Self, RunError> {
        let values = with_room(rows, width)?;
        Ok(Self {
            rows: Rows::Memory { values, width },
            count: 0,
        })
    }

    /// The file of an earlier session, to be continued behind the rows that its checkpoint counts.
    pub fn resume(
        path: &Path,
        header: &str,
        vouched: &Vouched,
        count: u64,
    ) -> Result<Self, RunError> {
        let file = Appended::resume(path, vouched)?;
        Ok(Self::of_file(file, header, count))
    }

    fn of_file(file: Appended, header: &str, count: u64) -> Self {
        let (headings, row) = (header.len() as u64, Table::default());
        Self {
            rows: Rows::File {
                file,
                headings,
                row,
            },
            count,
        }
    }

    /// The file, where there is one.
    fn file(&mut self) -> Option<&mut Appended> {
        match &mut self.rows {
            Rows::File { file, .. } => Some(file),
            Rows::Memory { .. } => None,
        }
    }

    /// Hands all rows to the disk and gives the file another name. A file of that name with the same rows, left by a
    /// session that was killed before its first checkpoint, is replaced.
    pub fn publish(&mut self, path: &Path) -> Result<(), RunError> {
        self.file().map_or(Ok(()), |file| {
            file.sync()?;
            file.rename(path)
        })
    }

    /// Prepares the file of an earlier session for more rows.
    ///
    /// Whole rows behind the checkpoint stay where the plan is the same. Its steps write the same bytes over them, so
    /// that a sample once on disk is there at every moment, however often the run is killed. Where the plan is longer,
    /// the last of them may be one that only the end of the shorter run asked for.
    pub fn go_on(&mut self, has_same_plan: bool) -> Result<(), RunError> {
        self.file().map_or(Ok(()), |file| file.cut(has_same_plan))
    }

    /// Appends one row.
    pub fn push(&mut self, time: f64, state: &[f64], observables: &[f64]) -> Result<(), RunError> {
        if let Rows::Memory { values, width } = &mut self.rows {
            make_room(values, *width)?;
        }
        self.count += 1;
        match &mut self.rows {
            Rows::File { file, row, .. } => {
                row.clear();
                let values = state.iter().chain(observables).copied();
                row.number(time).numbers(values).end_row();
                file.push(row.as_str().as_bytes())
            }
            Rows::Memory { values, .. } => {
                values.push(time);
                values.extend_from_slice(state);
                values.extend_from_slice(observables);
                Ok(())
            }
        }
    }

    /// Hands all rows to the operating system: they survive this program.
    pub fn flush(&mut self) -> Result<(), RunError> {
        self.file().map_or(Ok(()), Appended::flush)
    }

    /// Hands all rows to the disk: they survive the machine.
    pub fn sync(&mut self) -> Result<Vouched, RunError> {
        self.file().map_or(Ok(Vouched::NOTHING), Appended::sync)
    }

    /// Ends the file after the last row pushed.
    pub fn end(&mut self) -> Result<(), RunError> {
        self.file().map_or(Ok(()), Appended::end)
    }

    /// Refuses a file that does not end with the row that waits, if one does.
    pub fn confirm_end(&mut self) -> Result<(), RunError> {
        self.file().map_or(Ok(()), Appended::confirm_end)
    }

    /// Rows pushed.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// All rows one after the other, where they are in memory.
    pub fn into_values(self) -> Vec<f64> {
        match self.rows {
            Rows::File { .. } => Vec::new(),
            Rows::Memory { mut values, .. } => {
                values.shrink_to_fit();
                values
            }
        }
    }

    /// Every `stride`-th row and the last, of those that were handed over.
    pub fn read(&self, stride: usize) -> Result<Vec<Vec<f64>>, RunError> {
        let (count, stride) = (self.rows_in_memory(), stride.max(1));
        match &self.rows {
            Rows::File { file, headings, .. } => {
                let rows = read(file.path(), *headings, self.count, stride);
                rows.map_err(RunError::io(file.path()))
            }
            Rows::Memory { values, width } => {
                let rows = values.chunks_exact(*width).enumerate();
                let read = rows.filter(|(at, _)| at % stride == 0 || at + 1 == count);
                Ok(read.map(|(_, row)| row.to_vec()).collect())
            }
        }
    }

    /// For each of `columns` columns from `start` on, the time of its first value that is not finite.
    pub fn first_undefined(
        &self,
        start: usize,
        columns: usize,
    ) -> Result<Vec<Option<f64>>, RunError> {
        let mut found = vec![None; columns];
        let mut look = |row: &mut dyn Iterator<Item = f64>| {
            let time = row.next();
            for (first, value) in found.iter_mut().zip(row.skip(start - 1)) {
                if first.is_none() && !value.is_finite() {
                    *first = time;
                }
            }
        };
        match &self.rows {
            Rows::File { file, headings, .. } => {
                let error = RunError::io(file.path());
                let lines = match rows_behind(file.path(), *headings) {
                    Ok(lines) => lines,
                    Err(cause) => return Err(error(cause)),
                };
                for line in lines.take(self.rows_in_memory()) {
                    let line = match line {
                        Ok(line) => line,
                        Err(cause) => return Err(error(cause)),
                    };
                    // No other cell has such letters.
                    if line.contains("NaN") || line.contains("inf") {
                        look(&mut numbers(&line));
                    }
                }
            }
            Rows::Memory { values, width } => {
                for row in values.chunks_exact(*width) {
                    look(&mut row.iter().copied());
                }
            }
        }
        Ok(found)
    }

    fn rows_in_memory(&self) -> usize {
        usize::try_from(self.count).unwrap_or(usize::MAX)
    }
}

/// Whether a directory holds no sample but the first: what a session leaves that was killed before its
/// first checkpoint.
pub(super) fn has_begun_at_most(directory: &Path, header: &str) -> bool {
    match rows_behind(&directory.join(FILE), header.len() as u64) {
        Ok(lines) => lines.take(2).count() <= 1,
        Err(_) => !directory.join(FILE).exists(),
    }
}

/// The first `count` rows of a file as numbers behind so many bytes of headings, every `stride`-th and the last.
pub(super) fn read(
    path: &Path,
    headings: u64,
    count: u64,
    stride: usize,
) -> io::Result<Vec<Vec<f64>>> {
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    let mut lines = rows_behind(path, headings)?.take(count);
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
fn rows_behind(path: &Path, headings: u64) -> io::Result<io::Lines<BufReader<File>>> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(headings))?;
    Ok(BufReader::new(file).lines())
}
