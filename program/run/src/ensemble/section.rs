//! The crossings of all members, in one file.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use leafwise_scene::compose::Observable;

use super::plan::ComposedEnsemble;
use crate::appended::create_anew;
use crate::csv::{Headings, Table};
use crate::job::{PART, remove_parts};
use crate::samples::SECTION;
use crate::{Appended, RunError, Vouched};

/// Bytes of a member's rows that are held in memory.
const HELD: usize = 1 << 15;

/// A member's crossings until it is taken in: text, and the beginning of it in a file of its own where it is long.
#[derive(Default)]
pub(super) struct MemberCrossings {
    rows: Table,
    /// That file, where it is begun.
    part: Option<PathBuf>,
    /// How many.
    pub count: u64,
}

impl MemberCrossings {
    /// One more row of a member, in this directory where they are many.
    pub fn push(
        &mut self,
        (directory, member): (&Path, u64),
        time: f64,
        values: impl Iterator<Item = f64>,
    ) -> Result<(), RunError> {
        self.rows
            .whole(member)
            .number(time)
            .numbers(values)
            .end_row();
        self.count += 1;
        if self.rows.as_str().len() >= HELD {
            let (before, behind) = PART;
            let path = directory.join(format!("{before}{member}{behind}"));
            self.put_aside(&path).map_err(RunError::io(&path))?;
        }
        Ok(())
    }

    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.count = 0;
        if let Some(part) = self.part.take() {
            // The next session removes what stays.
            let _ = fs::remove_file(part);
        }
    }

    fn put_aside(&mut self, path: &Path) -> io::Result<()> {
        let mut file = match self.part {
            None => create_anew(path)?,
            Some(_) => OpenOptions::new().append(true).open(path)?,
        };
        self.part = Some(path.to_owned());
        file.write_all(self.rows.as_str().as_bytes())?;
        self.rows.clear();
        Ok(())
    }

    /// Hands all rows over.
    fn take(&mut self, into: &mut Appended) -> Result<(), RunError> {
        if let Some(part) = &self.part {
            let mut file = File::open(part).map_err(RunError::reading(part))?;
            let mut buffer = vec![0; HELD];
            loop {
                let read = file.read(&mut buffer).map_err(RunError::reading(part))?;
                if read == 0 {
                    break;
                }
                into.push(&buffer[..read])?;
            }
        }
        into.push(self.rows.as_str().as_bytes())
    }
}

impl Drop for MemberCrossings {
    fn drop(&mut self) {
        self.clear();
    }
}

/// The writer of `section.csv`; of nothing where the scene asks for none. Each row is a member's number and what a run's
/// section has; members follow each other by number, a member's crossings in time.
pub(super) struct SectionStore {
    file: Option<Appended>,
    /// Rows.
    pub count: u64,
}

impl SectionStore {
    /// A new file.
    pub fn create(ensemble: &ComposedEnsemble, directory: &Path) -> Result<Self, RunError> {
        remove_parts(directory).map_err(RunError::io(directory))?;
        let file = match ensemble.run.plan.events.section {
            None => None,
            Some(_) => {
                let mut file = Appended::create(&directory.join(SECTION))?;
                file.push(heading(ensemble).as_bytes())?;
                Some(file)
            }
        };
        Ok(Self { file, count: 0 })
    }

    /// The file of an earlier session, of which nothing is changed before [`go_on`](Self::go_on).
    pub fn resume(
        ensemble: &ComposedEnsemble,
        directory: &Path,
        vouched: &Vouched,
        count: u64,
    ) -> Result<Self, RunError> {
        let section = ensemble.run.plan.events.section.as_ref();
        let file = section.map(|_| Appended::resume(&directory.join(SECTION), vouched));
        let file = file.transpose()?;
        Ok(Self { file, count })
    }

    /// Prepares the file of an earlier session for more members.
    pub fn go_on(&mut self, directory: &Path) -> Result<(), RunError> {
        remove_parts(directory).map_err(RunError::io(directory))?;
        self.file.as_mut().map_or(Ok(()), |file| file.cut(false))
    }

    /// Makes sure that nothing stands behind what the checkpoint counts.
    ///
    /// # Errors
    /// [`RunError::Damaged`] where something does.
    pub fn confirm_end(&mut self) -> Result<(), RunError> {
        self.file.as_mut().map_or(Ok(()), Appended::confirm_end)
    }

    /// Appends the crossings of members in their order.
    pub fn push(&mut self, members: &mut [MemberCrossings]) -> Result<(), RunError> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        for member in members {
            member.take(file)?;
            self.count += member.count;
        }
        file.flush()
    }

    /// Appends what a shard's directory holds.
    pub fn append(
        &mut self,
        ensemble: &ComposedEnsemble,
        directory: &Path,
        vouched: &Vouched,
        count: u64,
    ) -> Result<(), RunError> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        self.count += count;
        let skipped = heading(ensemble).len() as u64;
        file.append_file(&directory.join(SECTION), vouched, skipped)
    }

    /// Hands everything to the disk; returns what a checkpoint may count.
    pub fn sync(&mut self) -> Result<Vouched, RunError> {
        match &mut self.file {
            Some(file) => file.sync(),
            None => Ok(Vouched::NOTHING),
        }
    }
}

/// The columns behind the member's number and the time.
pub(super) fn columns(ensemble: &ComposedEnsemble) -> Vec<String> {
    let observables = ensemble.run.plan.observables.iter();
    let mut names = ensemble.run.plan.states.names();
    names.extend(observables.map(|observable| Observable::name(observable).to_owned()));
    names
}

/// The first line of the file.
pub(super) fn heading(ensemble: &ComposedEnsemble) -> String {
    let mut headings = Headings::default();
    headings.extend(["member", "t"], "of the crossing");
    headings.extend(ensemble.run.plan.states.names(), "variable");
    headings.extend(ensemble.observables(), "observable");
    headings.table().as_str().to_owned()
}
