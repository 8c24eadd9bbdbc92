//! Each member's last state, appended to a file.

use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::block::Record;
use super::plan::ComposedEnsemble;
use crate::document::FinalStates;
use crate::run::RunError;

/// The files' names in the run directory.
pub(crate) const CSV: &str = "final_states.csv";
pub(crate) const BINARY: &str = "final_states.bin";

/// The writer of last states; of nothing where the scene asks for none.
///
/// CSV has a row for each member: its number, whether it reached the end, its own parameters, the
/// coordinates and the observables. The binary file holds the coordinates alone, doubles with the
/// least significant byte first, d a member. A member that failed has its last good state.
pub(super) struct FinalStore {
    file: Option<(PathBuf, File)>,
    waiting: Vec<u8>,
    bytes: u64,
}

impl FinalStore {
    /// A new file, or that of an earlier session cut back to `bytes`.
    pub fn open(
        ensemble: &ComposedEnsemble,
        directory: &Path,
        resumed: Option<u64>,
    ) -> Result<Self, RunError> {
        let mut store = Self {
            file: None,
            waiting: Vec::new(),
            bytes: resumed.unwrap_or(0),
        };
        let path = match ensemble.final_states {
            FinalStates::None => return Ok(store),
            FinalStates::Csv => directory.join(CSV),
            FinalStates::Binary => directory.join(BINARY),
        };
        let mut file = match resumed {
            None => File::create(&path).map_err(RunError::io(&path))?,
            Some(_) => {
                let file = OpenOptions::new().write(true).open(&path);
                file.map_err(RunError::resuming(&path))?
            }
        };
        let length = file.metadata().map_err(RunError::io(&path))?.len();
        if length < store.bytes {
            let bytes = store.bytes;
            return Err(RunError::Damaged {
                file: path,
                reason: format!("it has {length} bytes where the checkpoint counts {bytes}"),
            });
        }
        file.set_len(store.bytes).map_err(RunError::io(&path))?;
        file.seek(SeekFrom::Start(store.bytes))
            .map_err(RunError::io(&path))?;
        if resumed.is_none() && ensemble.final_states == FinalStates::Csv {
            store
                .waiting
                .extend_from_slice(heading(ensemble).as_bytes());
        }
        store.file = Some((path, file));
        Ok(store)
    }

    /// Appends the members of a block.
    pub fn push(&mut self, ensemble: &ComposedEnsemble, record: &Record) -> Result<(), RunError> {
        if self.file.is_none() {
            return Ok(());
        }
        let varied = ensemble.population.varied();
        for (member, lane, is_done) in record.members() {
            let state = &record.states[lane];
            if ensemble.final_states == FinalStates::Binary {
                let bytes = state.iter().flat_map(|x| x.to_le_bytes());
                self.waiting.extend(bytes);
                continue;
            }
            let outcome = if is_done { "done" } else { "failed" };
            let mut row = format!("{member},{outcome}");
            let parameters = varied.iter().map(|at| record.parameters[lane][*at]);
            let observables = record.last_sample(lane, ensemble.columns.len());
            let observables = observables.map(|value| if is_done { value } else { f64::NAN });
            for value in parameters.chain(state.iter().copied()).chain(observables) {
                // Writing to a string cannot fail.
                let _ = write!(row, ",{value:?}");
            }
            row.push('\n');
            self.waiting.extend_from_slice(row.as_bytes());
        }
        self.flush()
    }

    fn flush(&mut self) -> Result<(), RunError> {
        if let Some((path, file)) = &mut self.file {
            file.write_all(&self.waiting)
                .map_err(RunError::io(&*path))?;
            self.bytes += self.waiting.len() as u64;
            self.waiting.clear();
        }
        Ok(())
    }

    /// Hands everything to the disk; returns the file's length.
    pub fn sync(&mut self) -> Result<u64, RunError> {
        self.flush()?;
        if let Some((path, file)) = &self.file {
            file.sync_data().map_err(RunError::io(path))?;
        }
        Ok(self.bytes)
    }
}

fn heading(ensemble: &ComposedEnsemble) -> String {
    let mut columns = vec!["member".to_owned(), "outcome".to_owned()];
    let parameters = ensemble.run.system.parameters();
    let varied = ensemble.population.varied();
    columns.extend(varied.into_iter().map(|at| parameters[at].name.clone()));
    columns.extend(ensemble.run.names());
    columns.extend(ensemble.observables().into_iter().map(str::to_owned));
    let quoted: Vec<String> = columns
        .iter()
        .map(|column| crate::run::quoted(column))
        .collect();
    quoted.join(",") + "\n"
}
