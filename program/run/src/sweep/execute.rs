//! A sweep as a job, or a shard of it: computed, or joined from shards.

use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::page;
use super::plan::ComposedSweep;
use super::report::{SWEEP, SweepEnding, SweepReport};
use super::session::{Session, has_begun_at_most};
use crate::job::shards::{Portion, Whole};
use crate::job::{
    Beginning, Content, FilesRecord, Folder, Job, JobSubject, Output, files, hexadecimal,
};
use crate::{RunError, RunOptions, RunOutcome};
use leafwise_report::render_sweep;
use leafwise_scene::document::SceneDocument;

/// A sweep, or a shard of it, with a row for each setting. Shards are joined to the bytes of one process.
pub struct SweepJob<'a> {
    document: &'a SceneDocument,
    sweep: &'a ComposedSweep<'a>,
    portion: Portion<'a>,
    options: &'a RunOptions,
    threads: NonZeroUsize,
}

impl<'a> SweepJob<'a> {
    /// A job that makes these settings of a sweep, whose scene has passed its checks when it was composed.
    pub fn new(
        document: &'a SceneDocument,
        sweep: &'a ComposedSweep<'a>,
        portion: Portion<'a>,
        options: &'a RunOptions,
        threads: NonZeroUsize,
    ) -> Self {
        Self {
            document,
            sweep,
            portion,
            options,
            threads,
        }
    }

    /// `report.html`.
    fn page(&self, _: &Session<'a>, report: &SweepReport) -> Content {
        let table = report.table();
        let text = fs::read_to_string(&table).map_err(RunError::reading(&table))?;
        let command = &self.options.command;
        let data = page::data(self.document, self.sweep, report, &text, command);
        Ok(Some(render_sweep(&data)?.into_bytes()))
    }
}

impl<'a> Job<'a> for SweepJob<'a> {
    type Session = Session<'a>;
    type Report = SweepReport;

    const RECORDS: &'static [&'static str] = &[SWEEP];

    fn outputs() -> Vec<Output<Self, Session<'a>, SweepReport>> {
        vec![Output::page(Self::page)]
    }

    fn subject(&self) -> JobSubject<'_> {
        JobSubject {
            kind: self.portion.kind(Whole::Settings),
            document: self.document,
            run: &self.sweep.base,
            checks: &self.sweep.checks,
            files: read_files(self.sweep),
            shard: self.portion.record(),
            sources: self.portion.sources(),
            options: self.options,
        }
    }

    fn has_begun_at_most(&self, directory: &Path) -> bool {
        has_begun_at_most(self.sweep, directory)
    }

    fn begin(&'a self, folder: &Folder) -> Result<Session<'a>, RunError> {
        let settings = self.portion.items(self.sweep.settings().count());
        let mut session = Session::begin(self.sweep, folder, settings, self.threads)?;
        for shard in self.portion.shards() {
            session.append(shard).map_err(RunError::of_shard)?;
        }
        session.save()?;
        Ok(session)
    }

    fn resume(&'a self, folder: &Folder) -> Result<Session<'a>, RunError> {
        let settings = self.portion.items(self.sweep.settings().count());
        Session::resume(self.sweep, folder, settings, self.threads)
    }

    fn report(
        &self,
        session: &mut Session<'a>,
        outcome: RunOutcome,
        is_repeated: bool,
    ) -> Result<SweepReport, RunError> {
        Ok(session.report(outcome, is_repeated))
    }

    fn write_end(
        &self,
        beginning: Beginning<'_>,
        report: &SweepReport,
        directory: &Path,
    ) -> Result<(), RunError> {
        beginning.write_end(directory, SweepEnding::new(report))
    }
}

/// Record of the files that a sweep reads: values of sites, and its settings.
fn read_files(sweep: &ComposedSweep<'_>) -> Option<FilesRecord> {
    let of_run = files(&sweep.base);
    let Some((file, digest)) = &sweep.settings().file else {
        return of_run;
    };
    let mut all = Sha256::new_with_prefix(digest);
    let mut paths = vec![file.clone()];
    if let Some(record) = of_run {
        all.update(record.sha256.as_bytes());
        paths.extend(record.paths);
    }
    let sha256 = hexadecimal(&all.finalize());
    Some(FilesRecord { paths, sha256 })
}
