//! Each member's last state, appended to a file.

use std::path::Path;

use super::block::{Ended, Record};
use super::plan::ComposedEnsemble;
use crate::csv::{Headings, Table};
use crate::{Appended, RunError, Vouched};
use leafwise_scene::document::FinalStates;

/// The files' names in the run directory.
pub(crate) const CSV: &str = "final_states.csv";
pub(crate) const BINARY: &str = "final_states.bin";

/// The writer of last states; of nothing where the scene asks for none.
///
/// CSV has a row for each member: its number, how it has ended, when, where that differs, its own parameters, the last
/// coordinates, the observables, the initial coordinates and the invariants' largest deviations. The
/// binary file holds the last coordinates alone, doubles with the least significant byte first, d a
/// member. A member that failed has its last good state.
pub(super) struct FinalStore {
    file: Option<Appended>,
}

/// Where a scene keeps last states, if anywhere.
fn name(ensemble: &ComposedEnsemble) -> Option<&'static str> {
    match ensemble.final_states {
        FinalStates::None => None,
        FinalStates::Csv => Some(CSV),
        FinalStates::Binary => Some(BINARY),
    }
}

/// Whether a directory holds no last state: what a session leaves that was killed before its first
/// checkpoint.
pub(super) fn has_begun_at_most(ensemble: &ComposedEnsemble, directory: &Path) -> bool {
    let begun = name(ensemble).and_then(|name| directory.join(name).metadata().ok());
    begun.is_none_or(|file| file.len() <= heading(ensemble).len() as u64)
}

impl FinalStore {
    /// A new file.
    pub fn create(ensemble: &ComposedEnsemble, directory: &Path) -> Result<Self, RunError> {
        let Some(name) = name(ensemble) else {
            return Ok(Self { file: None });
        };
        let mut file = Appended::create(&directory.join(name))?;
        file.push(heading(ensemble).as_bytes())?;
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

    /// Appends the members of a block.
    pub fn push(&mut self, ensemble: &ComposedEnsemble, record: &Record) -> Result<(), RunError> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let varied = ensemble.population.varied();
        let mut rows = Table::default();
        let has_times = ensemble.run.plan.events.stop.is_some();
        let end = ensemble.time(ensemble.run.plan.steps);
        for (member, lane, ended) in record.members() {
            let state = ensemble.run.own(&record.states[lane]);
            if ensemble.final_states == FinalStates::Binary {
                let bytes: Vec<u8> = state.iter().flat_map(|x| x.to_le_bytes()).collect();
                file.push(&bytes)?;
                continue;
            }
            let is_whole = ended != Ended::Failed;
            let parameters = varied.iter().map(|at| record.parameters[lane][*at]);
            let known = |value: f64| if is_whole { value } else { f64::NAN };
            let measured = record.last_sample(lane, ensemble.columns.len());
            let measured = measured.into_iter().map(known);
            let drifts = record.largest_deviations(lane).map(known);
            rows.whole(member).text(ended.word());
            if has_times {
                rows.number(record.time(lane, end));
            }
            rows.numbers(parameters)
                .numbers(state.iter().copied())
                .numbers(measured)
                .numbers(
                    ensemble
                        .run
                        .own(&record.initial_states[lane])
                        .iter()
                        .copied(),
                )
                .numbers(drifts)
                .end_row();
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
                heading(ensemble).len() as u64,
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

/// The first line of the file; none of doubles.
fn heading(ensemble: &ComposedEnsemble) -> String {
    if ensemble.final_states != FinalStates::Csv {
        return String::new();
    }
    let mut headings = Headings::default();
    headings.extend(["member", "outcome"], "of the ensemble");
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
    headings.table().as_str().to_owned()
}
