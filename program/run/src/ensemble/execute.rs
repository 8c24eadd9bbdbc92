//! An ensemble as a job, or a shard of it: computed, or joined from shards.

use std::path::Path;

use serde::Serialize;

use super::advice::measured;
use super::drive::{Session, Workforce};
use super::ending::EnsembleEnding;
use super::plan::ComposedEnsemble;
use super::report::EnsembleReport;
use super::store::{self, has_begun_at_most};
use super::{page, tables};
use crate::job::shards::{Portion, Whole};
use crate::job::{Beginning, Content, Folder, Job, JobSubject, Output, files};
use crate::samples::SECTION;
use crate::start::checked;
use crate::{RunError, RunOptions, RunOutcome};
use leafwise_report::render_ensemble;
use leafwise_scene::compose::SceneChecks;
use leafwise_scene::document::SceneDocument;

/// An ensemble, or a shard of it, whose scene has passed its checks: its members are stepped and reduced.
///
/// Members that failed are counted, and no error. Shards are joined to the bytes of one process.
pub struct EnsembleJob<'a> {
    document: &'a SceneDocument,
    ensemble: &'a ComposedEnsemble,
    portion: Portion<'a>,
    options: &'a RunOptions,
    workforce: Workforce,
    checks: SceneChecks,
}

impl<'a> EnsembleJob<'a> {
    /// Checks a scene of which these members are made.
    ///
    /// # Errors
    /// [`RunError::Refused`] for a tensor that is not Poisson or a Casimir that is not one.
    pub fn new(
        document: &'a SceneDocument,
        ensemble: &'a ComposedEnsemble,
        portion: Portion<'a>,
        options: &'a RunOptions,
        workforce: Workforce,
    ) -> Result<Self, RunError> {
        Ok(Self {
            checks: checked(document, &ensemble.run, options.allow_non_poisson)?,
            document,
            ensemble,
            portion,
            options,
            workforce,
        })
    }

    /// `report.html`.
    fn page(&self, _: &Session<'a>, report: &EnsembleReport) -> Content {
        let data = page::data(self.document, self.ensemble, report, &self.options.command)
            .map_err(RunError::reading(&report.directory))?;
        Ok(Some(render_ensemble(&data)?.into_bytes()))
    }
}

impl<'a> Job<'a> for EnsembleJob<'a> {
    type Session = Session<'a>;
    type Report = EnsembleReport;

    const RECORDS: &'static [&'static str] = &[SECTION, store::CSV, store::BINARY, store::MATRIX];

    fn outputs() -> Vec<Output<Self, Session<'a>, EnsembleReport>> {
        vec![
            Output::table("statistics.csv", |job, _, report| {
                Ok(Some(tables::statistics(job.ensemble, report).into_bytes()))
            }),
            Output::table("windows.csv", |job, _, report| {
                Ok(Some(tables::windows(job.ensemble, report).into_bytes()))
            }),
            Output::table("losses.csv", |job, _, report| {
                let has_losses = job.ensemble.run.plan.events.stop.is_some();
                Ok(has_losses.then(|| tables::losses(job.ensemble, report).into_bytes()))
            }),
            Output::table("failures.csv", |job, _, report| {
                let has_failures = report.reductions.failed > 0;
                Ok(has_failures.then(|| tables::failures(job.ensemble, report).into_bytes()))
            }),
            Output::page(Self::page),
        ]
    }

    fn subject(&self) -> JobSubject<'_> {
        JobSubject {
            kind: self.portion.kind(Whole::Members),
            document: self.document,
            run: &self.ensemble.run,
            checks: &self.checks,
            files: files(&self.ensemble.run),
            shard: self.portion.record(),
            sources: self.portion.sources(),
            options: self.options,
        }
    }

    fn has_begun_at_most(&self, directory: &Path) -> bool {
        has_begun_at_most(self.ensemble, directory)
    }

    fn begin(&'a self, folder: &Folder) -> Result<Session<'a>, RunError> {
        let members = self.portion.items(self.ensemble.population.members());
        let mut session = Session::begin(self.ensemble, folder, members, self.workforce)?;
        for shard in self.portion.shards() {
            session.append(shard).map_err(RunError::of_shard)?;
        }
        session.save()?;
        Ok(session)
    }

    fn resume(&'a self, folder: &Folder) -> Result<Session<'a>, RunError> {
        let members = self.portion.items(self.ensemble.population.members());
        Session::resume(self.ensemble, folder, &members, self.workforce)
    }

    fn report(
        &self,
        session: &mut Session<'a>,
        outcome: RunOutcome,
        is_repeated: bool,
    ) -> Result<EnsembleReport, RunError> {
        let mut report = session.report(outcome, is_repeated);
        // Who interrupts an ensemble wants it to end.
        if self.portion.record().is_none() && report.outcome != RunOutcome::Interrupted {
            report.advice = measured(self.document, self.ensemble, &report);
        }
        Ok(report)
    }

    fn write_end(
        &self,
        beginning: Beginning<'_>,
        report: &EnsembleReport,
        directory: &Path,
    ) -> Result<(), RunError> {
        match self.portion.record() {
            None => beginning.write_end(directory, EnsembleEnding::new(self.ensemble, report)),
            Some(_) => beginning.write_end(
                directory,
                ShardEnding {
                    failed: report.reductions.failed,
                    wall_seconds: report.wall_seconds,
                    outcome: report.outcome.word(),
                },
            ),
        }
    }
}

/// The end of a shard's manifest.
#[derive(Serialize)]
struct ShardEnding {
    failed: u64,
    wall_seconds: f64,
    outcome: &'static str,
}
