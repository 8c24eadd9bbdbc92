//! Each member's last state, appended to a file.

use std::path::Path;

use super::plan::ComposedEnsemble;
use super::record::{Ended, Record};
use crate::csv::{Headings, Table};
use crate::states::header;
use crate::{Appended, RunError, Vouched};
use leafwise_scene::document::FinalStates;

/// The files' names in the run directory.
pub(crate) const CSV: &str = "final_states.csv";
pub(crate) const BINARY: &str = "final_states.bin";
pub(crate) const MATRIX: &str = "final_states.npy";

/// The writer of last states; of nothing where the scene asks for none.
///
/// CSV has a row for each member: its number, how it has ended, when, where that differs, and its own parameters. The
/// last coordinates, the observables, the initial coordinates and the invariants' largest deviations follow in the row.
/// The matrix of NumPy's holds the same but for the number, which is the row's, and 0, 1 or 2 for done, stopped and
/// failed. Its header counts the members from the beginning on. The binary file holds the last coordinates alone,
/// doubles with the least significant byte first, d a member. A member that failed has its last good state.
pub(super) struct FinalStore {
    file: Option<Appended>,
}

/// Where a scene keeps last states, if anywhere.
fn name(ensemble: &ComposedEnsemble) -> Option<&'static str> {
    match ensemble.final_states {
        FinalStates::None => None,
        FinalStates::Csv => Some(CSV),
        FinalStates::Binary => Some(BINARY),
        FinalStates::Npy => Some(MATRIX),
    }
}

/// Whether a directory holds no last state: what a session leaves that was killed before its first
/// checkpoint.
pub(super) fn has_begun_at_most(ensemble: &ComposedEnsemble, directory: &Path) -> bool {
    let begun = name(ensemble).and_then(|name| directory.join(name).metadata().ok());
    begun.is_none_or(|file| file.len() <= heading(ensemble, 0).len() as u64)
}

impl FinalStore {
    /// A new file, of so many members.
    pub fn create(
        ensemble: &ComposedEnsemble,
        directory: &Path,
        members: u64,
    ) -> Result<Self, RunError> {
        let Some(name) = name(ensemble) else {
            return Ok(Self { file: None });
        };
        let mut file = Appended::create(&directory.join(name))?;
        file.push(&heading(ensemble, members))?;
        Ok(Self { file: Some(file) })
    }

    /// The file of an earlier session, of which nothing is changed before [`go_on`](Self::go_on).
    pub fn resume(
        ensemble: &ComposedEnsemble,
        directory: &Path,
        vouched: &Vouched,
    ) -> Result<Self, RunError> {
        let path = name(ensemble).map(|name| directory.join(name));
        let file = path.map(|path| Appended::resume(&path, vouched));
        let file = file.transpose()?;
        Ok(Self { file })
    }

    /// Prepares the file of an earlier session for more members: rows that its checkpoint does not
    /// count go.
    pub fn go_on(&mut self) -> Result<(), RunError> {
        self.file.as_mut().map_or(Ok(()), |file| file.cut(false))
    }

    /// Makes sure that nothing stands behind what the checkpoint counts.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where something does.
    pub fn confirm_end(&mut self) -> Result<(), RunError> {
        self.file.as_mut().map_or(Ok(()), Appended::confirm_end)
    }

    /// Appends the members of a block.
    pub fn push(&mut self, ensemble: &ComposedEnsemble, record: &Record) -> Result<(), RunError> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let varied = ensemble.population.varied();
        let own = ensemble.run.plan.layout.coordinates();
        let mut rows = Table::default();
        let has_times = ensemble.run.plan.events.stop.is_some();
        let end = ensemble.end();
        for (member, lane, ended) in record.members() {
            let state = record.own(&record.states, lane).take(own);
            if ensemble.final_states == FinalStates::Binary {
                let bytes: Vec<u8> = state.flat_map(f64::to_le_bytes).collect();
                file.push(&bytes)?;
                continue;
            }
            let is_whole = ended != Ended::Failed;
            let parameters = varied
                .iter()
                .map(|at| record.parameters[at * record.lanes + lane]);
            let known = |value: f64| if is_whole { value } else { f64::NAN };
            let measured = record.last_sample(lane, ensemble.columns.len());
            let measured = measured.map(known);
            let drifts = record.largest_deviations(lane).map(known);
            let time = has_times.then(|| record.time(lane, end));
            let initial = record.own(&record.initial_states, lane).take(own);
            let numbers = (time.into_iter())
                .chain(parameters)
                .chain(state)
                .chain(measured)
                .chain(initial)
                .chain(drifts);
            if ensemble.final_states == FinalStates::Npy {
                let bytes = std::iter::once(ended.number()).chain(numbers);
                let bytes: Vec<u8> = bytes.flat_map(f64::to_le_bytes).collect();
                file.push(&bytes)?;
            } else {
                rows.whole(member)
                    .text(ended.word())
                    .numbers(numbers)
                    .end_row();
            }
        }
        file.push(rows.as_str().as_bytes())?;
        file.flush()
    }

    /// Appends what a shard's directory holds.
    pub fn append(
        &mut self,
        ensemble: &ComposedEnsemble,
        directory: &Path,
        vouched: &Vouched,
    ) -> Result<(), RunError> {
        match (&mut self.file, name(ensemble)) {
            (Some(file), Some(name)) => file.append_file(
                &directory.join(name),
                vouched,
                heading(ensemble, 0).len() as u64,
            ),
            _ => Ok(()),
        }
    }

    /// Hands everything to the disk; returns what a checkpoint may count.
    pub fn sync(&mut self) -> Result<Vouched, RunError> {
        match &mut self.file {
            Some(file) => file.sync(),
            None => Ok(Vouched::NOTHING),
        }
    }
}

/// The columns of the matrix; of decimals with the member's number before them, and none of doubles alone.
pub(super) fn columns(ensemble: &ComposedEnsemble) -> Option<(&'static str, Vec<String>)> {
    let is_numbered = ensemble.final_states == FinalStates::Csv;
    let headings = headings(ensemble, is_numbered);
    match ensemble.final_states {
        FinalStates::None | FinalStates::Binary => None,
        FinalStates::Csv => Some((CSV, headings.into_names())),
        FinalStates::Npy => Some((MATRIX, headings.into_names())),
    }
}

/// Header of a file of so many members: the headings of CSV or NumPy's header; empty for a binary file.
fn heading(ensemble: &ComposedEnsemble, members: u64) -> Vec<u8> {
    match ensemble.final_states {
        FinalStates::None | FinalStates::Binary => Vec::new(),
        FinalStates::Csv => headings(ensemble, true).table().as_str().into(),
        FinalStates::Npy => {
            let width = headings(ensemble, false).into_names().len();
            header(members, width).to_vec()
        }
    }
}

fn headings(ensemble: &ComposedEnsemble, is_numbered: bool) -> Headings {
    let mut headings = Headings::default();
    if is_numbered {
        headings.push("member", "of the ensemble");
    }
    headings.push("outcome", "of the ensemble");
    if ensemble.run.plan.events.stop.is_some() {
        headings.push("t", "of the ensemble");
    }
    let parameters = ensemble.run.system.parameters();
    let varied = ensemble.population.varied();
    headings.extend(varied.iter().map(|at| &parameters[*at].name), "parameter");
    let names = ensemble.run.names();
    headings.extend(&names, "variable");
    headings.extend(ensemble.observables(), "observable");
    headings.extend(
        names.iter().map(|name| format!("{name}_initial")),
        "variable",
    );
    let invariants = ensemble.invariant_names();
    headings.extend(
        invariants.iter().map(|name| format!("{name}_drift")),
        "invariant",
    );
    headings
}
