//! A job: a directory that is begun, interrupted, resumed, extended, ended and told of again.
//!
//! - [`Job`], [`JobSession`], [`perform`]: the frame, and what a run, an ensemble, a sweep and shards tell it;
//! - `subject`: whose scene is taken up, in which directory;
//! - `directory`: start afresh, resume, or refuse; `difference`: keys that changed between two scenes;
//! - `manifest`, `beginning`: record of a job, as it is read and as it is written; `time`: its date;
//! - `folder`: where its checkpoints are, and of which scene;
//! - `output`: files that are written at the end; `files`: what waits aside;
//! - `due`: when a checkpoint is written;
//! - [`shards`]: parts of ensembles and sweeps for many processes.

mod beginning;
mod difference;
mod directory;
mod due;
mod files;
mod folder;
mod manifest;
mod output;
pub mod shards;
mod subject;
mod time;

pub use beginning::Beginning;
pub(crate) use beginning::{files, plugins};
pub use directory::{Files, Held, default_directory};
pub(crate) use due::Due;
pub(crate) use files::{PART, remove_parts};
pub use folder::Folder;
pub(crate) use folder::SceneDigest;
pub(crate) use manifest::{CHECKPOINT, FILE as MANIFEST, REPORT, hexadecimal};
pub use manifest::{FilesRecord, Kind, Manifest, PROGRAM_VERSION, PluginRecord, ShardRecord};
pub use output::{Content, Output};
pub use subject::{JobSubject, RunOptions};

use std::fs;
use std::path::Path;

use directory::RunDirectory;
use manifest::SCENE;

use super::{Progress, RunError, RunOutcome, replace};

/// The work of a job between two steps, members or settings.
pub trait JobSession {
    /// Takes up the end that a resumed session had come to before, `None` where it is to go on. No file is changed.
    fn repeat(&mut self, held: &Held) -> Result<Option<RunOutcome>, RunError>;

    /// Prepares the records of a resumed session for more.
    fn go_on(&mut self, held: &Held) -> Result<(), RunError>;

    /// Works to the end, or until interrupted, with checkpoints.
    fn drive(&mut self, progress: &mut dyn Progress) -> Result<RunOutcome, RunError>;
}

/// Work into a directory: a run, an ensemble, a sweep, a shard of these, or shards joined.
pub trait Job<'a>: Sized {
    /// Its work.
    type Session: JobSession;
    /// How it ended.
    type Report;

    /// The names of files that grow while it is driven.
    const RECORDS: &'static [&'static str];

    /// The files that are written at its end, in their order. A shard has none.
    fn outputs() -> Vec<Output<Self, Self::Session, Self::Report>>;

    /// Whose scene is taken up, in which directory.
    fn subject(&self) -> JobSubject<'_>;

    /// Whether the records of a directory hold no more than what a session leaves that was killed before its first
    /// checkpoint.
    fn has_begun_at_most(&self, directory: &Path) -> bool;

    /// The first session: its records are begun, and a checkpoint written.
    fn begin(&'a self, folder: &Folder) -> Result<Self::Session, RunError>;

    /// The session of a checkpoint; no file is changed before [`go_on`](JobSession::go_on).
    fn resume(&'a self, folder: &Folder) -> Result<Self::Session, RunError>;

    /// Describes how a session has ended.
    fn report(
        &self,
        session: &mut Self::Session,
        outcome: RunOutcome,
        is_repeated: bool,
    ) -> Result<Self::Report, RunError>;

    /// Writes the manifest of a job that has ended.
    fn write_end(
        &self,
        beginning: Beginning<'_>,
        report: &Self::Report,
        directory: &Path,
    ) -> Result<(), RunError>;
}

/// The names of the files that jobs of a type leave, beside those of every job.
pub(crate) fn names<'a, J: Job<'a>>() -> Vec<&'static str> {
    let outputs = J::outputs().into_iter().map(|output| output.name);
    J::RECORDS.iter().copied().chain(outputs).collect()
}

/// Performs a job in its directory; `files` are those that jobs of each kind leave.
///
/// An unfinished job of the same scene is resumed, to the same bits as without interruption. One that has ended is told
/// of again, with nothing computed: files of its end that are not there are made anew, and others refused.
pub(crate) fn perform<'a, J: Job<'a>>(
    job: &'a J,
    files: Files,
    progress: &mut dyn Progress,
) -> Result<J::Report, RunError> {
    let subject = job.subject();
    let (is_joined, into) = (!subject.sources.is_empty(), &subject.options.directory);
    if subject
        .sources
        .iter()
        .any(|source| shards::is_same(source, into))
    {
        return Err(RunError::IntoShard {
            directory: into.clone(),
        });
    }
    let directory = RunDirectory::open(&subject, files)?;
    let (path, held) = (directory.path.as_path(), directory.held.as_ref());
    let outputs = match subject.shard {
        None => J::outputs(),
        Some(_) => Vec::new(),
    };
    let folder = Folder::of(path, &subject);
    let mut resumed = None;
    if let Some(held) = held.filter(|held| held.is_done || !is_joined)
        && (path.join(CHECKPOINT).exists() || !job.has_begun_at_most(path))
    {
        let mut session = job.resume(&folder)?;
        if let Some(outcome) = session.repeat(held)? {
            let report = job.report(&mut session, outcome, true)?;
            for output in &outputs {
                output.confirm(path, job, &session, &report)?;
            }
            return Ok(report);
        }
        // What is joined and has not all is joined anew.
        resumed = (!is_joined).then_some((session, held));
    }
    let beginning = Beginning::new(&subject, held.map(|held| held.started.clone()));
    // From here on the directory is that of this job, with nothing in it yet or all that was
    // recorded. The scene comes last: should a run that becomes longer be killed before, what is
    // there is the shorter one, unfinished.
    beginning.write_running(path)?;
    if let Some((session, held)) = &mut resumed {
        session.go_on(held)?;
    }
    replace(&path.join(SCENE), subject.document.text.as_bytes())?;
    let mut session = match resumed {
        Some((session, _)) => session,
        None => job.begin(&folder).inspect_err(|_| {
            if is_joined {
                // Nothing that a session could go on from.
                let records = J::RECORDS.iter().map(|name| path.join(name));
                records.for_each(|record| drop(fs::remove_file(record)));
            }
        })?,
    };
    let finish = || {
        let outcome = session.drive(progress)?;
        let report = job.report(&mut session, outcome, false)?;
        for output in &outputs {
            output.write(path, job, &session, &report)?;
        }
        job.write_end(beginning, &report, path)?;
        Ok(report)
    };
    finish().map_err(|error: RunError| error.with_a_checkpoint(path))
}
